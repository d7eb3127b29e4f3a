"""Runs of the study of memories, arranged by cell, controller and seed."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import polars as pl
from numpy.typing import NDArray

from dmil.analysis.panel import RunPanel, Values, check_success, numeric, on_axes
from dmil.experiments.cells import CITY
from dmil.results import Results
from dmil.studies.memories.names import with_cell

WAIT = "wait_per_spawned_s"
DIVERGED = "DivergedError"
"""What the status of a diverged run begins with."""


@dataclass(frozen=True, kw_only=True)
class Arranged(RunPanel):
    """All runs; the axes are ``cell``, ``controller`` and ``seed``.

    Of the measures, ``us_per_decision`` is of decisions for all intersections.

    Attributes
    ----------
    ablations: tuple of str
        Controllers that belong into a table of their own.
    learns: (controllers,) bool
    intersections: (cells,) float64
    planned, failed, diverged: arrays of bool
        Whether there is a run, whether it failed in whatever way, whether it diverged.
    """

    ablations: tuple[str, ...]
    learns: NDArray[np.bool_]
    intersections: Values
    planned: NDArray[np.bool_]
    failed: NDArray[np.bool_]
    diverged: NDArray[np.bool_]

    @property
    def cells(self) -> Sequence[str]:
        """Names, grids by size and load first."""
        return self.axes["cell"]

    @property
    def controllers(self) -> Sequence[str]:
        """Labels in the order of the study's plan."""
        return self.axes["controller"]


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
    runs = with_cell(runs.join(timings, on=key, how="left", nulls_equal=True)).with_columns(
        bytes_per_intersection=pl.col("bytes_total") / pl.col("intersections"),
        planned=True,
        failed=pl.col("status") != "ok",
        diverged=pl.col("status").str.starts_with(DIVERGED),
    )
    configuration = results.manifest.get("configuration", {})
    controllers = _in_order(runs["controller"].unique().sort().to_list(), configuration)
    axes = {
        "cell": sorted(runs["cell"].unique(), key=_cell_rank),
        "controller": controllers,
        "seed": sorted(runs["seed"].unique()),
    }
    array = on_axes(runs, axes)
    learners = set(runs.filter(pl.col("reward").is_not_null())["controller"])
    size = dict(runs.select("cell", "intersections").iter_rows())
    return Arranged(
        axes=axes,
        measures={name: array(name) for name in numeric(runs, but=("seed",))},
        ablations=tuple(name for name in configuration.get("ablations", ()) if name in controllers),
        learns=np.array([name in learners for name in controllers]),
        intersections=np.array([size[cell] for cell in axes["cell"]], np.float64),
        **{name: array(name, 0) > 0 for name in ("planned", "failed", "diverged")},
    )


def _in_order(found: list[str], configuration: dict[str, Any]) -> list[str]:
    planned = [name for name in configuration.get("controllers", ()) if name in found]
    return planned + [name for name in found if name not in planned]


def _cell_rank(name: str) -> tuple[Any, ...]:
    place, _, load = name.partition("*")
    size = re.search(r"(\d+)x(\d+)", place)
    intersections = int(size[1]) * int(size[2]) if size else 0
    return place.startswith(CITY), intersections, "/" in place, place, float(load or 1)
