"""How long a look-up takes at 5,000 keys, beside comparing the keys one by one.

Keys and questions are states of the paper's 5×5 grid at the paper's load, under SARSA with the
simple embedding; the questions come from an episode that no key comes from. Under the paper's
complex embedding these states fall into fewer than 5,000 classes, so rotations are measured on the
keys of the simple one, asked for in all four of them.
"""

from __future__ import annotations

from time import perf_counter

import numpy as np
import numpy.typing as npt

from dmil.benchmarks.figures import Decisions, SpeedFigure, pair
from dmil.compilation import kernel
from dmil.controllers.tabular.agents import classes_of
from dmil.controllers.tabular.sarsa import SarsaController
from dmil.controllers.tabular.settings import SarsaSettings
from dmil.memory import ABSENT, Rows, Scratch, append, look_up, make_rows, make_scratch
from dmil.rewards import diffusion
from dmil.scenarios import scenario
from dmil.seeding import stream
from dmil.simulation import QueueSimulator
from dmil.symmetry import EMBEDDINGS, Classes, Embedding, embed, vary
from dmil.training import run

IntArray = npt.NDArray[np.int32]
FloatArray = npt.NDArray[np.float64]

KEYS = 5000
QUESTIONS = 2000
EPISODES = 9
ROUNDS = 7
PER_S = {"µs": 1e6, "ns": 1e9}
SCENARIO = scenario("grid:5x5", horizon_s=3600)

SIMPLE = EMBEDDINGS["simple"]
TURNED = Embedding("simple in 4 rotations", rotations=True, tolerance=SIMPLE.tolerance)


def lookup_figures(
    *, keys: int = KEYS, episodes: int = EPISODES, rounds: int = ROUNDS
) -> list[SpeedFigure]:
    """Measure look-ups in compiled code; the scan must give the same answers.

    From a state to its row: the embedding's arithmetic is part of the time. Each round measures
    look-up and scan one after the other; figures are medians. The last episode is for questions.
    """
    states = visited_states(episodes)
    known, questions = np.split(states, [-len(states) // episodes])
    questions = questions[:: max(1, len(questions) // QUESTIONS)]
    figures = []
    for name, keyed, asked, unit in (
        ("L∞ ≤ 1 look-up", SIMPLE, SIMPLE, "µs"),
        ("L∞ ≤ 1 look-up in 4 rotations", SIMPLE, TURNED, "µs"),
        ("exact look-up", EMBEDDINGS["exact"], EMBEDDINGS["exact"], "ns"),
        ("cells look-up", EMBEDDINGS["cells"], EMBEDDINGS["cells"], "ns"),
    ):
        rows = filled_rows(classes_of(SCENARIO.network, keyed), known, keys)
        classes = classes_of(SCENARIO.network, asked)
        look_ups, scans = (_measure(rows, classes, questions, rounds) * PER_S[unit]).tolist()
        called = f"{name} at {keys} keys"
        figures += pair(called, look_ups, unit, f"{called}, by a scan", scans)
    return figures


def visited_states(episodes: int) -> IntArray:
    """Return the (decisions of all agents, movements) int32 states met in some episodes."""
    simulator, met = QueueSimulator(SCENARIO), Decisions()
    for episode in range(episodes):
        controller = SarsaController(SarsaSettings(embedding="simple", epsilon_decay=0.95))
        rng = stream(episode, "benchmark", "demand")
        vehicles = SCENARIO.demand.vehicles(SCENARIO.network, SCENARIO.horizon_s, rng)
        exploration = stream(episode, "benchmark", "exploration")
        run(simulator, controller, vehicles, diffusion, exploration, observers=[met])
    return np.concatenate(met.queue_veh)


def filled_rows(classes: Classes, states: IntArray, keys: int) -> Rows:
    """Return one owner's rows: the first classes that states fall into, so many of them."""
    rows = make_rows(1, keys, states.shape[1], classes.tolerance)
    _fill(rows, classes, states, make_scratch(classes))
    assert rows.size[0] == keys, "too few states for so many keys"
    return rows


def _measure(rows: Rows, classes: Classes, states: IntArray, rounds: int) -> FloatArray:
    """Return seconds per look-up and per scan: (2, rounds)."""
    scratch = make_scratch(classes)
    answers = np.zeros((2, len(states), 2), np.int32)
    times_s = np.zeros((2, rounds))
    # What the round before the first measures is the compiler.
    for timed in range(-1, rounds):
        for scans in (0, 1):
            begin = perf_counter()
            _ask(rows, classes, states, scratch, bool(scans), answers[scans])
            times_s[scans, timed] = (perf_counter() - begin) / len(states)
    assert np.array_equal(answers[0], answers[1]), "look-up and scan give different answers"
    return times_s


@kernel
def _fill(rows: Rows, classes: Classes, states: IntArray, scratch: Scratch) -> None:
    for i in range(states.shape[0]):
        if rows.size[0] == rows.keys.shape[1]:
            return
        embed(classes, states[i], scratch.key)
        if look_up(rows, classes, 0, 0, scratch.key, scratch)[0] == ABSENT:
            append(rows, 0, scratch.key)


@kernel
def _ask(
    rows: Rows,
    classes: Classes,
    states: IntArray,
    scratch: Scratch,
    scans: bool,
    answers: IntArray,
) -> None:
    """Look every state up; write row and variant."""
    for i in range(states.shape[0]):
        embed(classes, states[i], scratch.key)
        if scans:
            count = vary(classes, 0, scratch.key, scratch.variants)
            answer = _scan(rows, scratch.variants, count)
        else:
            answer = look_up(rows, classes, 0, 0, scratch.key, scratch)
        answers[i, 0], answers[i, 1] = answer


@kernel
def _scan(rows: Rows, variants: IntArray, count: int) -> tuple[int, int]:
    """Compare all keys one by one: nearest by L1, then oldest, then first variant."""
    best_row, best_variant, best_distance = ABSENT, 0, 0
    for row in range(rows.size[0]):
        for variant in range(count):
            distance = 0
            for place in range(variants.shape[1]):
                off = abs(rows.keys[0, row, place] - variants[variant, place])
                if off > rows.tolerance:
                    distance = -1
                    break
                distance += off
            if distance >= 0 and (best_row == ABSENT or distance < best_distance):
                best_row, best_variant, best_distance = row, variant, distance
    return best_row, best_variant
