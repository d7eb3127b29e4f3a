"""All tables of a study of capacity, computed once for page, figures and command line."""

from __future__ import annotations

from dataclasses import dataclass

import polars as pl

from dmil.analysis.panel import check_success
from dmil.results import Results
from dmil.studies.capacity.capacities import Growth, capacities, curves, searched
from dmil.studies.capacity.recoveries import courses, disturbances

ORDER = ("scenario", "controller")


@dataclass(frozen=True, slots=True)
class CapacityTables:
    """What is known about a study of capacity: see the functions of these names.

    ``networks``, ``controllers`` and ``seeds`` are what ran, in the order of the plan; ``failures``
    says where runs failed, and what they said.
    """

    networks: tuple[str, ...]
    controllers: tuple[str, ...]
    seeds: tuple[int, ...]
    capacities: pl.DataFrame
    curves: pl.DataFrame
    disturbances: pl.DataFrame
    courses: pl.DataFrame
    failures: pl.DataFrame


def capacity_tables(results: Results) -> CapacityTables:
    """Compute all tables of a study of capacity (ours).

    Raises
    ------
    InputError
        No run succeeded.
    """
    runs = results.runs()
    check_success(runs, results)
    configuration = results.manifest.get("configuration", {})
    networks = [name.rpartition("*")[0] for name in configuration["networks"]]
    found: Growth = searched(
        runs,
        {
            "scenario": [name for name in networks if name in runs["scenario"]],
            "controller": [
                name for name in configuration["controllers"] if name in runs["controller"]
            ],
            "seed": sorted(runs["seed"].unique()),
        },
        configuration["tolerance"],
    )
    return CapacityTables(
        tuple(found.axes["scenario"]),
        tuple(found.axes["controller"]),
        tuple(found.axes["seed"]),
        capacities(found),
        curves(found, configuration["levels"]),
        disturbances(runs, found.axes),
        courses(results, found.axes),
        results.query(
            "select controller, scenario, load, seed, variant, status from runs"
            " where status <> 'ok' order by all"
        ),
    )
