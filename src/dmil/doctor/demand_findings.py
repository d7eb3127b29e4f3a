"""What is wrong or suspicious about the vehicles, and whether the signals can serve them."""

from __future__ import annotations

import math
from collections.abc import Iterator

from dmil.demand import CityflowDemand, SumoDemand
from dmil.demand.sumo.remarks import TEXTS
from dmil.doctor.case import Case
from dmil.doctor.findings import Finding, Severity
from dmil.doctor.intersections import IntersectionFacts
from dmil.doctor.kinds import finding
from dmil.doctor.traffic import Traffic

LATE_START_S = 600
LONG_END_S = 3600
FEW = 0.05
"""Vehicles outside of the run's time are worth a warning from this share on."""
FULL, SOME = 1.0, 0.5


def on_demand(
    case: Case, traffic: Traffic | None, intersections: tuple[IntersectionFacts, ...]
) -> Iterator[Finding]:
    """Look for what is wrong or suspicious about the vehicles (ours)."""
    yield from case.found
    if isinstance(case.demand, SumoDemand | CityflowDemand):
        yield from _on_remarks(case.demand, traffic)
    if traffic is None:
        return
    if all(each.kind != "no-vehicle-in-time" for each in case.found):
        yield from _on_times(case, traffic)
    if traffic.signalled_share < SOME:
        yield finding(
            "few-pass-signals", "demand", f"{1 - traffic.signalled_share:.0%} of the vehicles"
        )
    if traffic.giving_way_share > SOME:
        yield finding("give-way", "demand", f"{traffic.giving_way_share:.0%} of the vehicles")
    lane_veh_per_s = case.dynamics.saturation_flow_veh_per_s
    for link, entries_veh_per_s in zip(case.network.links, traffic.entries_veh_per_s, strict=True):
        lanes = link.open_lanes
        if entries_veh_per_s > lanes * lane_veh_per_s:
            yield finding(
                "entry-beyond-capacity",
                f"link {link.id}",
                f"{3600 * entries_veh_per_s:.0f} vehicles per hour begin there, "
                f"{lanes} lane{'s' if lanes > 1 else ''} take "
                f"{3600 * lanes * lane_veh_per_s:.0f}",
            )
    for item in intersections:
        yield from _on_load(item)


def _on_remarks(demand: SumoDemand | CityflowDemand, traffic: Traffic | None) -> Iterator[Finding]:
    for remark in demand.remarks:
        known = TEXTS[remark.kind]
        where = remark.text.removeprefix(known).strip(" ()").removeprefix("at ")
        what = f"{remark.count} {known.partition(';')[0]}"
        place = f"first '{remark.example}'" + (f" at {where}" if where else "")
        severity: Severity | None = None
        if remark.kind in ("before-begin", "after-end"):
            all_veh = remark.count + (traffic.vehicles if traffic else 0)
            severity = "note" if remark.count < FEW * all_veh else "warning"
        yield finding(remark.kind, place, what, severity=severity)


def _on_times(case: Case, traffic: Traffic) -> Iterator[Finding]:
    early_s = traffic.first_s - case.begin_s
    if early_s > LATE_START_S:
        yield finding(
            "late-start",
            "demand",
            f"a run begins at {case.begin_s} s, the first vehicle departs at {traffic.first_s} s",
            mend=f"Set the begin to it: --begin {traffic.first_s}.",
        )
    idle_s = case.begin_s + case.horizon_s - traffic.last_s
    if idle_s > LONG_END_S:
        yield finding(
            "long-end",
            "demand",
            f"a run ends {idle_s} s after the last departure at {traffic.last_s} s",
        )


def _on_load(item: IntersectionFacts) -> Iterator[Finding]:
    load, place = item.load, f"intersection {item.id}"
    if load is None:
        return
    if not item.vehicles:
        yield finding("idle-intersection", place, "no vehicles pass")
        return
    if load.degree > FULL:
        yield finding(
            "demand-beyond-capacity",
            place,
            f"degree of saturation in the busiest 15 minutes: {load.degree:.0%}",
        )
    elif load.program_degree is not None and load.program_degree > FULL:
        needed = (
            "green but get none"
            if math.isinf(load.program_degree)
            else f"{load.program_degree:.2f} times the green that they have"
        )
        yield finding(
            "program-beyond-capacity",
            place,
            f"in the busiest 15 minutes some vehicles need {needed}; the best splits give a degree "
            f"of saturation of {load.degree:.0%}",
        )
    for index, phase in enumerate(item.phases):
        if not phase.vehicles:
            yield finding(
                "idle-phase",
                place,
                f"no vehicle uses the movements of phase {index} ({phase.name})",
            )
