"""Runs of the study of memories, arranged by cell, controller and seed."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import numpy as np
import polars as pl
from numpy.typing import NDArray

from dmil.analysis.panel import check_success, panel_of
from dmil.results import Results
from dmil.studies.memories.names import CITY, cell_name

Values = NDArray[np.float64]
WAIT = "wait_per_spawned_s"
DIVERGED = "DivergedError"
"""What the status of a diverged run begins with."""


@dataclass(frozen=True)
class Arranged:
    """All runs of a study as (cells, controllers, seeds) arrays.

    Attributes
    ----------
    cells: tuple of str
        Names, grids by size and load first.
    controllers: tuple of str
        Labels in the order of the study's plan.
    ablations: tuple of str
        Those that belong into a table of their own.
    learns: tuple of bool
        Whether a controller learns.
    seeds: tuple of int
    intersections: (cells,) float64
    measures: dict
        Column of ``runs`` to an array; NaN where there is no run, or it failed. Beside these
        ``bytes_per_intersection`` and ``us_per_decision``, one decision being for all
        intersections.
    planned, failed, diverged: arrays of bool
        Whether there is a run, whether it failed in whatever way, whether it diverged.
    """

    cells: tuple[str, ...]
    controllers: tuple[str, ...]
    ablations: tuple[str, ...]
    learns: tuple[bool, ...]
    seeds: tuple[int, ...]
    intersections: Values
    measures: dict[str, Values]
    planned: NDArray[np.bool_]
    failed: NDArray[np.bool_]
    diverged: NDArray[np.bool_]

    def number(self, controller: str) -> int | None:
        """Return the number of a controller, None if it was not run."""
        return self.controllers.index(controller) if controller in self.controllers else None

    def of(self, measure: str, controller: str) -> Values:
        """Return a measure of one controller, (cells, seeds); NaN if it was not run."""
        number = self.number(controller)
        shape = len(self.cells), len(self.seeds)
        return np.full(shape, np.nan) if number is None else self.measures[measure][:, number]

    def task(self, measure: str, cell: int) -> Values:
        """Return a measure in one cell as (seeds, controllers), as statistics take it."""
        values: Values = self.measures[measure][cell].T
        return values


def arranged(results: Results) -> Arranged:
    """Arrange the runs of a study (ours).

    Raises
    ------
    InputError
        No run succeeded.
    """
    runs = results.runs()
    check_success(runs, results)
    timings = results.query(
        "select scenario, load, seed, controller, 1e6 * decide_s / decisions as us_per_decision"
        " from timings where decisions > 0"
    )
    key = ["scenario", "load", "seed", "controller"]
    runs = runs.join(timings, on=key, how="left", nulls_equal=True).with_columns(
        bytes_per_intersection=pl.col("bytes_total") / pl.col("intersections"),
        cell=pl.Series([cell_name(*row) for row in runs.select("scenario", "load").rows()]),
        ok=pl.col("status") == "ok",
        diverged=pl.col("status").str.starts_with(DIVERGED),
    )
    cells = sorted(runs["cell"].unique(), key=_cell_rank)
    configuration = results.manifest.get("configuration", {})
    controllers = _in_order(runs["controller"].unique().sort().to_list(), configuration)
    seeds = sorted(runs["seed"].unique())
    axes = (cells, "cell"), (controllers, "controller"), (seeds, "seed")
    panel = panel_of(*((values, runs[column].to_list()) for values, column in axes))
    known = set(runs.filter(pl.col("reward").is_not_null())["controller"])
    size = dict(runs.select("cell", "intersections").iter_rows())

    planned = panel.flags(pl.repeat(True, runs.height, eager=True))
    return Arranged(
        tuple(cells),
        tuple(controllers),
        tuple(name for name in configuration.get("ablations", ()) if name in controllers),
        tuple(name in known for name in controllers),
        tuple(seeds),
        np.array([size[cell] for cell in cells], np.float64),
        panel.measures(runs, but=("seed",)),
        planned,
        planned & ~panel.flags(runs["ok"]),
        panel.flags(runs["diverged"]),
    )


def _in_order(found: list[str], configuration: dict[str, Any]) -> list[str]:
    planned = [name for name in configuration.get("controllers", ()) if name in found]
    return planned + [name for name in found if name not in planned]


def _cell_rank(name: str) -> tuple[Any, ...]:
    place, _, load = name.partition("*")
    size = re.search(r"(\d+)x(\d+)", place)
    intersections = int(size[1]) * int(size[2]) if size else 0
    return place.startswith(CITY), intersections, "/" in place, place, float(load or 1)
