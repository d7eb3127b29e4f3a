"""What look-ahead gives against rules and factored memory, and what each ingredient adds.

Prints the tables of docs/decisions/0005-look-ahead-near-saturation.md; takes about a quarter of an
hour on one core (cities: DIR holds a folder per city in CityFlow's format)::

    .venv/bin/python scripts/look_ahead.py rivals --data DIR
    .venv/bin/python scripts/look_ahead.py ingredients --data DIR

All controllers of a seed meet the same vehicles and learn online from the first second. Differences
are paired, with 95 % bootstrap intervals.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from dmil.controllers import make_controller
from dmil.controllers.variants import parse_variant
from dmil.rewards import make_reward
from dmil.seeding import stream
from dmil.simulation import QueueSimulator
from dmil.statistics import paired_difference
from dmil.studies.memories.cells import GRID_CELLS, Cell
from dmil.training import evaluate, vehicles_of_seed

RIVALS = [
    "lookahead",
    "max-pressure",
    "longest-queue-first",
    "longest-queue-first,approaching=true",
    "factored",
]
PLAIN = "lookahead,plan=1,curvature=0,rounds=0,expected=0,later=1,queue_trust=1"
INGREDIENTS = [
    "lookahead",
    "lookahead,curvature=0",
    "lookahead,plan=1",
    "lookahead,depth=1",
    "lookahead,queue_trust=1",
    "lookahead,queue_trust=0",
    "lookahead,rounds=0",
    "lookahead,rounds=1",
    "lookahead,wave=0",
    "lookahead,learning=false",
    PLAIN,
    f"{PLAIN.replace(',curvature=0', '')}",
]
CELLS = {
    "rivals": [*GRID_CELLS, "cityflow:jinan_3x4", "cityflow:hangzhou_4x4"],
    "ingredients": ["grid:1x1*7", "grid:3x3*4", "grid:5x5", "grid:5x5*3.6", "cityflow:jinan_3x4"],
}


def delays(cell: Cell, variants: list[str], seeds: range, data: Path | None) -> np.ndarray:
    """Return W in s, in cities the travel time, of an hour: (seeds, variants) float64."""
    made = cell.build(3600, data)
    simulator, reward, found = QueueSimulator(made), make_reward("queue"), []
    for seed in seeds:
        vehicles = vehicles_of_seed(made, seed)
        found.append([])
        for text in variants:
            variant = parse_variant(text)
            controller = make_controller(variant.name, variant.options)
            measures = evaluate(simulator, controller, vehicles, reward, seed).measures
            found[-1].append(
                measures.travel_time_s if cell.is_city else measures.wait_per_spawned_s
            )
    return np.array(found)


def changes(one: np.ndarray, other: np.ndarray) -> list[str]:
    """Return differences to another in %, with their intervals."""
    change = paired_difference(one, other, stream(0, "bootstrap", "look-ahead"), relative=True)
    return [
        f"{100 * value:+.1f} [{100 * low:+.1f}, {100 * high:+.1f}]"
        for value, low, high in zip(change.value, change.low, change.high, strict=True)
    ]


def main() -> None:
    """Read what to run from the command line and print its table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("table", choices=list(CELLS))
    parser.add_argument("--cells", nargs="+", help="others than all")
    parser.add_argument("--seeds", type=int, default=30)
    parser.add_argument("--seed", type=int, default=2000, help="first of the seeds")
    parser.add_argument("--data", type=Path)
    chosen = parser.parse_args()
    seeds = range(chosen.seed, chosen.seed + chosen.seeds)
    variants = RIVALS if chosen.table == "rivals" else INGREDIENTS
    print("| cell | " + " | ".join(variants) + " |\n|" + "-|" * (len(variants) + 1))
    for name in chosen.cells or CELLS[chosen.table]:
        delay = delays(Cell.parse(name), variants, seeds, chosen.data)
        own = np.repeat(delay[:, :1], len(variants) - 1, axis=1)
        # Rivals: what look-ahead changes; ingredients: what a variant changes.
        pair = (own, delay[:, 1:]) if chosen.table == "rivals" else (delay[:, 1:], own)
        cells = [f"{delay[:, 0].mean():.2f} s", *changes(*pair)]
        print(f"| {name} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
