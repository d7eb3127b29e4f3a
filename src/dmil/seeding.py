"""One master seed, named independent streams.

No other module makes a random generator, so one seed fixes every draw of a run.
"""

from __future__ import annotations

import hashlib
import random

import numpy as np

LARGEST_SEED = 2**53 - 1
"""Largest master seed of a command: whole in JSON, and with 64 bits in a table."""


def stream(seed: int, *names: str | int) -> np.random.Generator:
    """Return the independent random stream that belongs to a seed and a name.

    The same seed and names always give the same stream, whatever other streams were made before:
    adding a stream to the program never changes another one.

    Parameters
    ----------
    seed
        Master seed, a non-negative integer.
    names
        Path of the stream, such as ``"demand"`` or ``"training", "exploration"``.
    """
    digest = hashlib.blake2b(
        "/".join(str(name) for name in names).encode(), digest_size=16
    ).digest()
    words = [int.from_bytes(digest[i : i + 4], "little") for i in range(0, 16, 4)]
    sequence = np.random.SeedSequence(entropy=seed, spawn_key=tuple(words))
    return np.random.Generator(np.random.PCG64(sequence))


def tuning_seeds(seed: int, count: int) -> list[int]:
    """Return master seeds for choosing a controller's options.

    All are larger than `LARGEST_SEED`, so that no test has one of them: what was tuned never meets
    the chance that it was tuned on.

    Parameters
    ----------
    seed
        Master seed of the tuning.
    count
        How many; the first ones do not depend on it.
    """
    draws = stream(seed, "tuning", "seeds")
    return [int(draws.integers(LARGEST_SEED + 1, 2**62)) for _ in range(count)]


def simulator_seed(seed: int, *names: str | int) -> int:
    """Return a seed for the chance inside a simulator, 0 to 2³¹ − 2.

    Parameters
    ----------
    seed
        Master seed.
    names
        Path below it; the number does not depend on anything else.
    """
    return int(stream(seed, *names, "simulator").integers(2**31 - 1))


def global_random_state() -> tuple[object, ...]:
    """Return the state of the random numbers that all programs share, to see that none uses them.

    Returns
    -------
    state
        Equal to another one as long as nobody draws from, or seeds, Python's or numpy's global
        random numbers in between.
    """
    shared = np.random.get_state(legacy=False)
    normal = shared["has_gauss"], shared["gauss"]
    words = shared["state"]
    return random.getstate(), *normal, words["pos"], words["key"].tobytes()
