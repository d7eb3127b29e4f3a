"""Saved arrays: taken apart by name, and checked before they replace anything."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from dmil.arrays import Array, Arrays
from dmil.errors import PolicyError


def saved_array(
    arrays: Arrays, name: str, shape: Sequence[int], kind: npt.DTypeLike, *, least: float = -np.inf
) -> Array:
    """Return a saved array that is what it should be (ours).

    Parameters
    ----------
    arrays
        All that was saved, by name.
    name, shape, kind
        What is wanted.
    least
        Smallest number that is allowed.

    Raises
    ------
    PolicyError
        If it is missing, of another shape or type, or a number in it is too small or not finite.
    """
    found = arrays.get(name)
    expected = f"{tuple(shape)} finite numbers, {np.dtype(kind)}"
    if least > -np.inf:
        expected += f", {least:g} or more"
    if found is None:
        problem = "is missing"
    elif found.shape != tuple(shape) or found.dtype != kind:
        problem = f"holds {found.shape} numbers, {found.dtype}"
    elif not (np.isfinite(found).all() and (found >= least).all()):
        problem = "holds numbers that cannot be"
    else:
        return found
    raise PolicyError(
        f"array '{name}' {problem}",
        where="saved memory",
        expected=expected,
        mend="train it again with this version of dmil and the same options",
    )


def named(prefix: str, arrays: Arrays) -> dict[str, Array]:
    """Return arrays with a prefix before every name (ours)."""
    return {f"{prefix}.{name}": array for name, array in arrays.items()}


def part(prefix: str, arrays: Arrays) -> dict[str, Array]:
    """Return the arrays whose names have a prefix, without it (ours)."""
    start = f"{prefix}."
    return {
        name.removeprefix(start): array for name, array in arrays.items() if name.startswith(start)
    }
