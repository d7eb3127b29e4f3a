"""How long the look-ups of MFEC and NEC take at 10,000 entries, beside scipy's tree.

MFEC's keys and questions are states of the paper's 5×5 grid at the paper's load, the counts of the
eight movements that need a signal; the questions are not among the keys, so that the hash answers
none of them. NEC's are drawn at random in 32 dimensions, where no index spares much comparing.
"""

from __future__ import annotations

from time import perf_counter

import numpy as np
from scipy.spatial import cKDTree

from dmil.arrays import FloatArray
from dmil.benchmarks.figures import SpeedFigure, in_turns, pair
from dmil.benchmarks.lookups import SCENARIO, visited_states
from dmil.compilation import kernel
from dmil.controllers.episodic.by_shape import signalled_columns
from dmil.memory.episodic import estimate, recall_mean
from dmil.memory.neighbours import (
    Entries,
    KeyArray,
    Neighbours,
    insert,
    make_entries,
    make_neighbours,
    tick,
)
from dmil.seeding import stream

ENTRIES = 10_000
QUESTIONS = 500
EPISODES = 12
ROUNDS = 7
EMBEDDING = 32
SOFTENING = 1e-3
MFEC, NEC = "MFEC look-up, 11 nearest of", "NEC look-up, 50 nearest of"


def neighbour_figures(
    *, entries: int = ENTRIES, episodes: int = EPISODES, rounds: int = ROUNDS
) -> list[SpeedFigure]:
    """Measure look-ups in compiled code; scipy's tree must find neighbours as near.

    The last episode is for MFEC's questions; figures are medians over the rounds.
    """
    rng = stream(0, "benchmark", "embeddings")
    drawn = rng.standard_normal((entries + QUESTIONS, EMBEDDING)).astype(np.float32)
    return [
        *_figures(f"{MFEC} {entries}", *states_apart(entries, episodes), 11, False, rounds),
        *_figures(f"{NEC} {entries}", drawn[:entries], drawn[entries:], 50, True, rounds),
    ]


def states_apart(entries: int, episodes: int) -> tuple[KeyArray, KeyArray]:
    """Return different states as keys, and states that are none of them as questions."""
    columns = signalled_columns(SCENARIO.network)[0][0]
    states = visited_states(episodes)[:, columns].astype(np.float32)
    known, asked = np.split(states, [-len(states) // episodes])
    _, first = np.unique(known, axis=0, return_index=True)
    assert len(first) >= entries, "too few states for so many entries"
    keys = known[np.sort(first)[:entries]]
    taken = set(map(bytes, keys))
    return keys, np.array([key for key in asked if bytes(key) not in taken][:QUESTIONS])


def _figures(
    name: str, keys: KeyArray, questions: KeyArray, count: int, weighted: bool, rounds: int
) -> list[SpeedFigure]:
    store, nearest = make_entries(1, len(keys), keys.shape[1]), make_neighbours(count)
    for key in keys:
        insert(store, 0, key, float(key.sum()), tick(store))
    tree = cKDTree(keys.astype(np.float64))
    farthest = np.zeros(len(questions))
    found: dict[str, FloatArray] = {}

    def ask() -> float:
        begin = perf_counter()
        _ask(store, questions, nearest, weighted, farthest)
        return (perf_counter() - begin) * 1e6 / len(questions)

    def ask_tree() -> float:
        begin = perf_counter()
        found["tree"] = tree.query(questions, count)[0][:, -1]
        return (perf_counter() - begin) * 1e6 / len(questions)

    ask()  # compiled
    mine, other = in_turns({"mine": ask, "tree": ask_tree}, rounds).values()
    # Two sums of squares in single and in double precision.
    assert np.allclose(np.sqrt(farthest), found["tree"], rtol=1e-4), "other neighbours are nearer"
    return pair(name, mine, "µs", f"{name}, by scipy's cKDTree", other)


@kernel
def _ask(
    store: Entries, questions: KeyArray, nearest: Neighbours, weighted: bool, farthest: FloatArray
) -> None:
    """Look every question up as NEC or as MFEC does; write the largest distance."""
    for i in range(questions.shape[0]):
        if weighted:
            recall_mean(store, 0, questions[i], SOFTENING, nearest, True)
        else:
            estimate(store, 0, questions[i], nearest, True)
        farthest[i] = nearest.distance[nearest.distance.shape[0] - 1]
