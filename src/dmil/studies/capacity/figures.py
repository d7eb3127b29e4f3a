"""All figures of the study of capacity, named, titled and explained."""

from __future__ import annotations

from collections.abc import Iterator

from dmil.reports.export import Drawn, Figure, drawn_figures
from dmil.studies.capacity import charts
from dmil.studies.capacity.disturbed import INCIDENT, SURGE
from dmil.studies.capacity.tables import CapacityTables


def figures_of_study(tables: CapacityTables, horizon_s: int) -> Iterator[Figure]:
    """Yield the figures that the runs allow (ours)."""
    who = tables.controllers
    drawn: list[Drawn] = [
        (
            "capacity",
            "capacity",
            "The highest load that each controller keeps stable. Load 1 is the network's own "
            "demand, at a steady rate.",
            charts.capacity_chart(tables.capacities, who),
        ),
        (
            "delay-over-load",
            "curves",
            "Lines end where the interval of growth lies above the tolerance, or where some seeds "
            "were not stable any more at a lower load.",
            charts.curve_chart(tables.curves, who),
        ),
        (
            "disturbances",
            "disturbances",
            "How much longer vehicles are delayed, on average over the whole run, than without "
            "the disturbance under the same controller.",
            charts.disturbance_chart(tables.disturbances, who),
        ),
        *(
            (
                f"after-{name}",
                "recovery",
                "Vehicles that wait in the network or outside, less those of the undisturbed run "
                "in the same second.",
                charts.course_chart(tables.courses, who, name, horizon_s),
            )
            for name in (INCIDENT, SURGE)
        ),
    ]
    yield from drawn_figures(drawn)
