"""What the doctor says on a terminal of 80 columns."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby

from rich.console import RenderableType
from rich.text import Text

from dmil.cli.doctor_tables import (
    BUSY,
    FULL,
    by_shape,
    indented,
    inside,
    intersection_text,
    one_each,
    percent,
    short,
)
from dmil.cli.measures import own_or_s
from dmil.cli.terminal import entries
from dmil.doctor import Diagnosis, Finding
from dmil.doctor.findings import Severity
from dmil.doctor.traffic import PEAK_S
from dmil.reports.labels import counted
from dmil.scenarios.names import shown

MOST_ROWS = 24
"""Networks of more intersections are summarised by shape."""
DETAILED = 3
"""Networks of up to so many intersections show all of each."""
MOST_EXAMPLES = 3
LONGEST_WORD = 48
_BARS = "▁▂▃▄▅▆▇█"
_COLOUR: dict[Severity, str] = {"error": "bold red", "warning": "yellow", "note": "cyan"}


def network_text(diagnosis: Diagnosis, everything: bool) -> Iterator[RenderableType]:
    """Say what the network is."""
    facts, case = diagnosis.network, diagnosis.case
    yield Text(shown(case.name), "bold")
    if case.files:
        yield inside(Text(", ".join(path.name for path in case.files), "dim"))
    yield ""
    shapes = counted(facts.shapes, "shape")
    yield Text("Network", "bold")
    yield inside(
        entries(
            {
                "roads": f"{counted(facts.links, 'link')}, {facts.road_km:.1f} km "
                f"({facts.lane_km:.1f} km of lanes), {_speeds(diagnosis)}",
                "signals": f"{counted(facts.intersections, 'intersection')} of "
                f"{shapes}; equal shapes may share a memory",
                "other nodes": f"{counted(facts.junctions, 'junction')} without signals, "
                f"{facts.fringe} boundary nodes",
            }
        )
    )
    yield ""
    rows = diagnosis.intersections
    yield Text("Intersections", "bold")
    yield inside(by_shape(rows) if len(rows) > MOST_ROWS and not everything else one_each(rows))
    if everything or len(rows) <= DETAILED:
        yield ""
        for each in rows:
            yield from intersection_text(each)
    else:
        yield ""


def demand_text(diagnosis: Diagnosis) -> Iterator[RenderableType]:
    """Say who drives, when, and whether the signals can serve it."""
    traffic, case = diagnosis.traffic, diagnosis.case
    yield Text("Demand", "bold")
    if traffic is None:
        yield inside(Text("no vehicles; also give route files"))
        yield ""
        return
    minutes = traffic.bar_s // 60
    drawn = " (drawn at random; these are of seed 0)" if traffic.random else ""
    yield inside(
        entries(
            {
                "vehicles": f"{traffic.vehicles:,}, from {_time(traffic.first_s)} to "
                f"{_time(traffic.last_s)}{drawn}",
                "departures": f"{sparkline(traffic.departures)}  {min(traffic.departures)} to "
                f"{max(traffic.departures)} per {f'{minutes} min' if minutes > 1 else 'min'}",
                "routes": f"{traffic.length_m:.0f} m and {traffic.links:.1f} links on average,  "
                f"{traffic.free_flow_s:.0f} s without delay",
                "signals": f"{traffic.signalled_share:.0%} of the vehicles pass one; "
                f"{traffic.signals_passed:.1f} on average",
                "run": f"{_time(case.begin_s)} to {_time(case.begin_s + case.horizon_s)}; a "
                f"decision every {case.timing.decision_interval_s} s, clearance "
                f"{own_or_s(case.timing.clearance_s)}",
                "capacity": _verdict(diagnosis),
            }
        )
    )
    yield ""


def findings_text(findings: Sequence[Finding], everything: bool) -> Iterator[RenderableType]:
    """List findings with their mends, those of one kind together."""
    if not findings:
        yield Text("No errors, warnings or notes.", "green")
        return
    counts = [
        counted(sum(each.severity == severity for each in findings), severity)
        for severity in _COLOUR
        if any(each.severity == severity for each in findings)
    ]
    yield Text.assemble(("Findings", "bold"), f"  {', '.join(counts)}")
    for (severity, kind), group in groupby(findings, lambda each: (each.severity, each.kind)):
        yield from _kind_text(severity, kind, list(group), everything)


def _kind_text(
    severity: Severity, kind: str, group: list[Finding], everything: bool
) -> Iterator[RenderableType]:
    times = f" × {len(group)}" if len(group) > 1 else ""
    yield inside(Text.assemble((severity, _COLOUR[severity]), "  ", (f"{kind}{times}", "bold")))
    shown = group if everything else group[:MOST_EXAMPLES]
    mends = {each.mend for each in shown}
    for each in shown:
        place = each.place if everything else " ".join(map(_cut, each.place.split(" ")))
        yield indented(Text(f"{place}: {each.what}", overflow="fold"), 4)
        if len(mends) > 1:
            yield indented(Text(f"→ {each.mend}", "dim", overflow="fold"), 6)
    if len(group) > len(shown):
        yield indented(Text(f"and {len(group) - len(shown)} more (--all)", "dim"), 4)
    if len(mends) == 1:
        yield indented(Text(f"→ {group[0].mend}", "dim", overflow="fold"), 4)


def sparkline(counts: Sequence[int]) -> str:
    """Draw numbers as bars of text, from 0 to the largest."""
    most = max(counts, default=0) or 1
    return "".join(_BARS[-(-(len(_BARS) - 1) * count // most)] for count in counts)


def _speeds(diagnosis: Diagnosis) -> str:
    facts = diagnosis.network
    ends = [f"{each:.0f}" for each in (facts.slowest_km_per_h, facts.fastest_km_per_h)]
    return f"{' to '.join(dict.fromkeys(ends))} km/h"


def _verdict(diagnosis: Diagnosis) -> Text:
    loads = {item.id: item.load.degree for item in diagnosis.intersections if item.load}
    name = max(loads, key=loads.__getitem__)
    period = " in its busiest 15 min" if diagnosis.case.horizon_s > PEAK_S else ""
    words, style = (
        ("exceeded", "bold red")
        if loads[name] > FULL
        else ("nearly exceeded", "yellow")
        if loads[name] > BUSY
        else ("sufficient", "green")
    )
    return Text.assemble(
        (words, style),
        f": degree of saturation {percent(loads[name]).plain} at intersection "
        f"{short(name)}{period}",
    )


def _time(seconds: int) -> str:
    if seconds < 3600:
        return f"{seconds} s"
    minutes, rest = divmod(seconds, 60)
    hours, minutes = divmod(minutes, 60)
    return f"{seconds} s ({hours}:{minutes:02d}:{rest:02d})"


def _cut(word: str) -> str:
    """Cut ids that would fill lines; the beginning of one is enough for --intersection."""
    return word if len(word) <= LONGEST_WORD else short(word)
