"""What options of a controller give: the tables of two records in docs/decisions.

long-term-memory is 0001 (half an hour on one core), rivals and ingredients are 0005 (a quarter of
an hour; DIR holds a folder per city in CityFlow's format)::

    .venv/bin/python scripts/variants.py long-term-memory
    .venv/bin/python scripts/variants.py long-term-memory --cells grid:3x3 --steps 3600
    .venv/bin/python scripts/variants.py rivals --data DIR

All variants of a seed share its vehicles, the draws of their exploration and, where they begin from
one, the start table, trained as `dmil study paper` trains it in its preset `matched`. The first row
is the mean, the others are paired differences in % with 95 % bootstrap intervals.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from pathlib import Path

import numpy as np

from dmil.controllers import Prior, make_controller
from dmil.controllers.variants import Variant, parse_variant
from dmil.experiments.cells import Cell
from dmil.experiments.study import Kept, run_trials
from dmil.parallel import LocalExecutor
from dmil.rewards import make_reward
from dmil.scenarios import Scenario
from dmil.seeding import stream
from dmil.simulation import QueueSimulator
from dmil.statistics import paired_difference
from dmil.studies.memories.plan import GRID_CELLS
from dmil.studies.paper.settings import PRESETS
from dmil.training import evaluate, train_prior, vehicles_of_seed

MATCHED = PRESETS["matched"]
BASE = "dual-memory,embedding=complex-scaled"
LONGEST = "unseen=longest-queue"
UNTRAINED = "untrained "
"""Begins with an empty table where others begin with what the dummy agent has learned."""
PLAIN = "lookahead,plan=1,curvature=0,rounds=0,expected=0,later=1,queue_trust=1"
CITIES = ("cityflow:jinan_3x4", "cityflow:hangzhou_4x4")


@dataclass(frozen=True)
class Question:
    """Variants, and where they run. The change is the first one's where ``of_first`` is set."""

    variants: tuple[str, ...]
    cells: tuple[str, ...]
    rng: str
    steps: tuple[int, ...] = (3600,)
    rewards: tuple[str, ...] = ("queue",)
    of_first: bool = False
    prior: bool = False


QUESTIONS = {
    "long-term-memory": Question(
        (
            BASE,
            f"{BASE},staging=visits",
            f"{BASE},least_tried=3",
            *(f"{BASE},long_capacity={cap}" for cap in (256, 64, 16)),
            f"{BASE},long_capacity=64,least_tried=3",
            f"{BASE},{LONGEST}",
            *(f"{BASE},{LONGEST},long_capacity={cap}" for cap in (256, 64, 16)),
            f"{BASE},unseen=nearest",
            *(f"{BASE},unseen=nearest,long_capacity={cap}" for cap in (256, 64, 16)),
            f"{BASE},unseen=nearest,long_capacity=64,least_tried=3",
            f"{BASE},{LONGEST},long_capacity=64,least_tried=3",
            f"{BASE},communication=true",
            f"{BASE},communication=true,long_capacity=64",
            f"{BASE},communication=true,long_capacity=64,unseen=nearest",
            "dual-memory,embedding=simple",
            "dual-memory,embedding=simple,long_capacity=256",
            f"dual-memory,embedding=simple,{LONGEST}",
            "dual-memory,embedding=simple,unseen=nearest,long_capacity=256",
            "sarsa,embedding=simple",
            f"sarsa,embedding=simple,{LONGEST}",
            "sarsa,embedding=simple,unseen=nearest",
            f"{UNTRAINED}{BASE}",
            f"{UNTRAINED}{BASE},{LONGEST}",
            f"{UNTRAINED}{BASE},{LONGEST},learning=false",
            "longest-queue-first",
            "max-pressure",
        ),
        ("grid:3x3", "grid:5x5"),
        "long-term memory",
        steps=(300, 3600),
        rewards=("diffusion", "default"),
        prior=True,
    ),
    "rivals": Question(
        (
            "lookahead",
            "max-pressure",
            "longest-queue-first",
            "longest-queue-first,approaching=true",
            "factored",
        ),
        (*GRID_CELLS, *CITIES),
        "look-ahead",
        of_first=True,
    ),
    "ingredients": Question(
        (
            "lookahead",
            *(f"lookahead,{option}" for option in ("curvature=0", "plan=1", "depth=1")),
            *(f"lookahead,queue_trust={trust}" for trust in (1, 0)),
            *(f"lookahead,rounds={rounds}" for rounds in (0, 1)),
            *(f"lookahead,{option}" for option in ("wave=0", "learning=false")),
            PLAIN,
            PLAIN.replace(",curvature=0", ""),
        ),
        ("grid:1x1*7", "grid:3x3*4", "grid:5x5", "grid:5x5*3.6", CITIES[0]),
        "look-ahead",
    ),
}
Place = tuple[str, int, str]
"""Cell, length of a run in s, reward."""


@lru_cache(maxsize=2)
def parts(cell: str, steps: int, data: Path | None) -> tuple[Scenario, QueueSimulator]:
    """Return a scenario and its simulator; what is derived from a network is kept with it."""
    made = Cell.parse(cell).build(steps, data)
    return made, QueueSimulator(made)


@lru_cache(maxsize=1)
def start(cell: str, steps: int, data: Path | None, reward: str, seed: int) -> Prior:
    """Return the start table of a seed."""
    longer = replace(parts(cell, steps, data)[0], horizon_s=MATCHED.training_factor * steps)
    return train_prior(longer, make_reward(reward), seed, simulator=QueueSimulator(longer))


def run(
    question: Question, data: Path | None, trial: tuple[Place, int, Variant, bool]
) -> tuple[object, tuple[float, float, float]]:
    """Return a trial's delay, its entries and its bytes per agent."""
    (cell, steps, reward), seed, variant, trained = trial
    made, simulator = parts(cell, steps, data)
    learns = question.prior and variant.name in ("sarsa", "dual-memory")
    options = {"epsilon": 0.4, "epsilon_decay": MATCHED.epsilon_decay} if learns else {}
    prior = start(cell, steps, data, reward, seed) if learns and trained else None
    controller = make_controller(variant.name, options | dict(variant.options), prior=prior)
    found = evaluate(simulator, controller, vehicles_of_seed(made, seed), make_reward(reward), seed)
    measures, memory = found.measures, found.memory[-1]
    # In cities the travel time; the paper's measure at its horizon; W at others.
    delay = measures.w_over_vc if steps == 300 else measures.wait_per_spawned_s
    delay = measures.travel_time_s if Cell.parse(cell).is_city else delay
    return trial, (delay, memory.entries, memory.bytes_total / len(made.network.intersections))


def table(question: Question, reward: str, seeds: range, data: Path | None, jobs: int) -> str:
    """Return one reward's table in Markdown; entries and bytes are those of the last column."""
    places = [(cell, steps, reward) for steps in question.steps for cell in question.cells]
    read = [
        (parse_variant(text.removeprefix(UNTRAINED)), not text.startswith(UNTRAINED))
        for text in question.variants
    ]
    plan = [(place, seed, *each) for place in places for seed in seeds for each in read]
    kept = Kept()
    run_trials(plan, kept, lambda _: partial(run, question, data), executor=LocalExecutor(jobs))
    numbers = np.array([kept[trial][1] for trial in plan])
    numbers = numbers.reshape(len(places), len(seeds), len(read), 3)
    columns = []
    for (_, steps, _), delay in zip(places, numbers[..., 0], strict=True):
        own = np.repeat(delay[:, :1], len(read), axis=1)
        rng = stream(0, "bootstrap", question.rng)
        pair = (own, delay) if question.of_first else (delay, own)
        change = paired_difference(*pair, rng, relative=True)
        ends = 100 * np.stack([change.value, change.low, change.high], axis=1)
        mean = delay[:, 0].mean()
        columns.append([f"**{mean:.4g}**" if steps == 300 else f"**{mean:.2f} s**"])
        columns[-1] += [f"{at:+.1f} [{low:+.1f}, {high:+.1f}]" for at, low, high in ends[1:]]
    heads = ["variant", *(f"{cell}, {steps} s" for cell, steps, _ in places), "entries", "bytes"]
    sizes = numbers[-1, ..., 1:].mean(axis=0)
    rows = [heads, ["-"] * len(heads)]
    for text, *cells, (entries, size) in zip(question.variants, *columns, sizes, strict=True):
        rows.append([f"`{text}`", *cells, f"{entries:.0f}", f"{size:.0f}"])
    lines = "\n".join(f"| {' | '.join(row)} |" for row in rows)
    return f"### Reward {reward}\n\n{lines}\n"


def main() -> None:
    """Read the question from the command line and print its tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("question", choices=list(QUESTIONS))
    parser.add_argument("--cells", nargs="+", help="others than those of the record")
    parser.add_argument("--steps", nargs="+", type=int, help="length of a run in s")
    parser.add_argument("--reward", nargs="+")
    parser.add_argument("--seeds", type=int, default=30)
    parser.add_argument("--seed", type=int, default=2000, help="first of the seeds")
    parser.add_argument("--data", type=Path)
    parser.add_argument("--jobs", type=int, default=1)
    chosen = parser.parse_args()
    given = {"cells": chosen.cells, "steps": chosen.steps, "rewards": chosen.reward}
    question = replace(
        QUESTIONS[chosen.question], **{name: tuple(each) for name, each in given.items() if each}
    )
    seeds = range(chosen.seed, chosen.seed + chosen.seeds)
    for reward in question.rewards:
        print(table(question, reward, seeds, chosen.data, chosen.jobs), flush=True)


if __name__ == "__main__":
    main()
