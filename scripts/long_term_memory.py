"""What each option of the long-term memory gives, against the paper's literal rules.

Prints the tables of docs/decisions/0001-long-term-memory.md; takes about half an hour on one core::

    .venv/bin/python scripts/long_term_memory.py
    .venv/bin/python scripts/long_term_memory.py --grid 3x3 --horizon 3600 --reward queue

Every seed has vehicles and a start table of its own, trained as `dmil study paper` trains it in its
preset `matched` (10 times as long as the run, ε × 0.95 per decision); all variants of a seed share
them and the draws of their exploration. Differences are paired, with 95 % bootstrap intervals.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from functools import lru_cache

import numpy as np

from dmil.controllers import make_controller
from dmil.controllers.variants import parse_variant
from dmil.rewards import make_reward
from dmil.scenarios import Scenario, scenario
from dmil.seeding import stream
from dmil.simulation import QueueSimulator
from dmil.statistics import paired_difference
from dmil.studies.paper.settings import PRESETS
from dmil.training import evaluate, train_prior, vehicles_of_seed

MATCHED = PRESETS["matched"]
AGENT = {"epsilon": 0.4, "epsilon_decay": MATCHED.epsilon_decay}
UNTRAINED = "untrained "
"""What a variant without a start table begins with."""
BASE = "dual-memory,embedding=complex-scaled"
LONGEST = "unseen=longest-queue"
VARIANTS = [
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
]


@lru_cache(maxsize=2)
def parts(grid: str, horizon_s: int) -> tuple[Scenario, QueueSimulator, Scenario, QueueSimulator]:
    """Return where it is tested and where the start table is trained."""
    test = scenario(f"grid:{grid}", horizon_s=horizon_s)
    training = replace(test, horizon_s=MATCHED.training_factor * horizon_s)
    return test, QueueSimulator(test), training, QueueSimulator(training)


def numbers(grid: str, horizon_s: int, reward_name: str, seed: int) -> np.ndarray:
    """Return delay, entries and bytes per agent of every variant: (variants, 3) float64."""
    test, simulator, training, training_simulator = parts(grid, horizon_s)
    reward, vehicles = make_reward(reward_name), vehicles_of_seed(test, seed)
    start = train_prior(training, reward, seed, simulator=training_simulator)
    found = []
    for text in VARIANTS:
        variant = parse_variant(text.removeprefix(UNTRAINED))
        learns = variant.name in ("sarsa", "dual-memory")
        options = (AGENT if learns else {}) | dict(variant.options)
        prior = start if learns and not text.startswith(UNTRAINED) else None
        controller = make_controller(variant.name, options, prior=prior)
        result = evaluate(simulator, controller, vehicles, reward, seed)
        measures, memory = result.measures, result.memory[-1]
        # The paper's measure at its horizon, seconds per vehicle at others.
        delay = measures.w_over_vc if horizon_s == 300 else measures.wait_per_spawned_s
        agents = len(test.network.intersections)
        found.append((delay, memory.entries, memory.bytes_total / agents))
    return np.array(found)


def column(grid: str, horizon_s: int, reward: str, seeds: range) -> tuple[list[str], np.ndarray]:
    """Return one setting's cells, one per variant, and mean entries and bytes per agent."""
    runs = np.stack([numbers(grid, horizon_s, reward, seed) for seed in seeds])
    delay = runs[:, :, 0]
    literal = np.repeat(delay[:, :1], len(VARIANTS), axis=1)
    rng = stream(0, "bootstrap", "long-term memory")
    change = paired_difference(delay, literal, rng, relative=True)
    unit = "" if horizon_s == 300 else " s"
    cells = [f"**{delay[:, 0].mean():.4g}{unit}**"]
    for i in range(1, len(VARIANTS)):
        low, value, high = (100 * one[i] for one in (change.low, change.value, change.high))
        cells.append(f"{value:+.1f} [{low:+.1f}, {high:+.1f}]")
    return cells, runs[:, :, 1:].mean(axis=0)


def table(settings: list[tuple[str, int]], reward: str, seeds: range) -> str:
    """Return one reward's table in Markdown; entries and bytes are those of the last setting."""
    columns = [column(grid, horizon_s, reward, seeds) for grid, horizon_s in settings]
    heads = [f"{grid}, {horizon_s} s" for grid, horizon_s in settings]
    rows = [["variant", *heads, "entries", "bytes"], ["-"] * (len(heads) + 3)]
    for i, text in enumerate(VARIANTS):
        entries, size = columns[-1][1][i]
        cells = [cells[i] for cells, _ in columns]
        rows.append([words(text), *cells, f"{entries:.0f}", f"{size:.0f}"])
    lines = ["| " + " | ".join(row) + " |" for row in rows]
    return f"### Reward {reward}\n\n" + "\n".join(lines)


def words(text: str) -> str:
    """Return what a table calls a variant."""
    if text == BASE:
        return "dual-memory, literal"
    if text == UNTRAINED + BASE:
        return "literal, no start table"
    shown = text.removeprefix(UNTRAINED).removeprefix(BASE + ",").removeprefix("dual-memory,")
    return f"`{shown}`" + (", no start table" if text.startswith(UNTRAINED) else "")


def main() -> None:
    """Read the settings from the command line and print their tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--grid", nargs="+", default=["3x3", "5x5"])
    parser.add_argument("--horizon", nargs="+", type=int, default=[300, 3600], help="in s")
    parser.add_argument("--reward", nargs="+", default=["diffusion", "default"])
    parser.add_argument("--seeds", type=int, default=30)
    parser.add_argument("--seed", type=int, default=2000, help="first of the seeds")
    chosen = parser.parse_args()
    seeds = range(chosen.seed, chosen.seed + chosen.seeds)
    settings = [(grid, horizon_s) for horizon_s in chosen.horizon for grid in chosen.grid]
    for reward in chosen.reward:
        print(table(settings, reward, seeds) + "\n", flush=True)


if __name__ == "__main__":
    main()
