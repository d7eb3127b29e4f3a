"""What the doctor says on a terminal of 80 columns."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import groupby

from rich.console import RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from dmil.cli.terminal import clearance, entries, table
from dmil.doctor import Diagnosis, Finding, IntersectionFacts
from dmil.doctor.findings import Severity
from dmil.doctor.traffic import PEAK_S
from dmil.reports.labels import counted
from dmil.scenarios.names import shown

LONGEST_ID, ROADS_WIDTH = 21, 15
FULL, BUSY = 1.0, 0.85
"""Degrees of saturation from which on a load is red, and yellow."""
FIGURES = (">moves", ">phases", ">sym")
_folded = partial(table, overflow="fold")
_packed = partial(_folded, padding=(0, 0, 0, 0))
_LETTER = {"right": "R", "straight": "F", "left": "L", "uturn": "U"}


def intersection_text(item: IntersectionFacts) -> Iterator[RenderableType]:
    """Say all about one intersection."""
    alike = "none" if item.alike == 1 else str(item.alike - 1)
    yield Text(f"Intersection {item.id}", "bold")
    lines = {
        "shape": f"{item.shape}; {alike} other{'s' if item.alike > 2 else ''} of this shape; "
        f"symmetry group of {item.symmetries}",
        "movements": f"{item.movements}"
        + (f"; unsignalled, always open: {item.unsignalled}" if item.unsignalled else ""),
    }
    if item.junctions > 1:
        lines["junctions"] = f"{item.junctions} under one signal controller"
    if item.program_kind:
        lines["own program"] = _program(item)
    if item.load:
        lines["load"] = _load_text(item)
    yield indented(entries(lines))
    yield ""
    yield indented(_approaches(item))
    yield ""
    yield indented(_phases(item))
    yield ""


def one_each(rows: Sequence[IntersectionFacts]) -> Table:
    """Return one row for every intersection."""
    made = _packed("!id", "!shape", "roads in", *FIGURES, *_plan_heads(rows))
    made.columns[2].min_width = min(ROADS_WIDTH, max(len(_lanes(item)) for item in rows))
    for item in rows:
        made.add_row(short(item.id), item.shape, _lanes(item), *_figures(item), *_plan(item, rows))
    return made


def by_shape(rows: Sequence[IntersectionFacts]) -> Table:
    """Return one row for every shape, with its busiest intersection."""
    made = _packed("!shape", ">number", "!such as", *FIGURES, *_plan_heads(rows))
    for shape in dict.fromkeys(item.shape for item in rows):
        same = [item for item in rows if item.shape == shape]
        busiest = max(same, key=lambda item: item.load.degree if item.load else 0.0)
        made.add_row(
            shape, str(len(same)), short(busiest.id), *_figures(busiest), *_plan(busiest, rows)
        )
    return made


def _figures(item: IntersectionFacts) -> tuple[str, str, str]:
    return str(item.movements), str(len(item.phases)), str(item.symmetries)


def _plan_heads(rows: Sequence[IntersectionFacts]) -> list[str]:
    heads = [">cycle"] if any(item.program_kind for item in rows) else []
    if any(item.load for item in rows):
        heads += [">load"]
        if any(item.load and item.load.program_degree is not None for item in rows):
            heads += [">plan"]
    return heads


def _plan(item: IntersectionFacts, rows: Sequence[IntersectionFacts]) -> list[str | Text]:
    cells: dict[str, str | Text] = {
        ">cycle": f"{item.cycle_s:.0f} s" if item.program_kind else "–",
        ">load": percent(item.load.degree if item.load else None),
        ">plan": percent(item.load.program_degree if item.load else None),
    }
    return [cells[head] for head in _plan_heads(rows)]


def percent(share: float | None) -> Text:
    """Return a degree of saturation, 1 for all that can be served, coloured if it is high."""
    if share is None:
        return Text("–")
    style = "bold red" if share > FULL else "yellow" if share > BUSY else ""
    return Text(f"{share:.0%}" if share < 10 else "> 999%", style)


def _lanes(item: IntersectionFacts) -> str:
    between = ":" if item.approaches[0].name.isdigit() else ""
    return " ".join(f"{each.name}{between}{each.lanes}" for each in item.approaches)


def _approaches(item: IntersectionFacts) -> Table:
    made = _folded("!from", "!link", ">lanes", ">length", "turns (lanes)")
    for each in item.approaches:
        turns = ", ".join(f"{_LETTER[turn]} {lanes}" for turn, lanes in each.turns)
        made.add_row(each.name, short(each.link), str(each.lanes), f"{each.length_m:.0f} m", turns)
    return made


def _phases(item: IntersectionFacts) -> Table:
    heads = [">phase", "serves"]
    heads += [">green"] if item.program_kind else []
    heads += [">vehicles", ">time needed"] if item.load else []
    made = _folded(*heads)
    for index, phase in enumerate(item.phases):
        row: list[str | Text] = [str(index), phase.name]
        if item.program_kind:
            row.append("–" if phase.planned_green_s is None else f"{phase.planned_green_s:g} s")
        if item.load:
            row += [str(phase.vehicles), percent(phase.load)]
        made.add_row(*row)
    return made


def _program(item: IntersectionFacts) -> str:
    parts = [
        f"({seconds:g})" if phase is None else f"{seconds:g} [{phase}]"
        for seconds, phase in item.stages
    ]
    offset = f", offset {item.offset_s:g} s" if item.offset_s else ""
    return (
        f"{item.program_kind}, cycle {item.cycle_s:g} s{offset}: {' '.join(parts)}\n"
        "seconds [phase], (clearance)"
    )


def _load_text(item: IntersectionFacts) -> str:
    assert item.load is not None, "shown only where there is one"
    if not item.vehicles:
        return "no vehicles pass"
    own = item.load.program_degree
    planned = "" if own is None else f"; with its program {percent(own).plain}"
    return (
        f"{item.vehicles} vehicles pass; degree of saturation in the busiest 15 min "
        f"{percent(item.load.degree).plain}{planned}"
    )


def short(name: str) -> str:
    """Return an id that does not fill a line; its beginning is enough to name it."""
    return name if len(name) <= LONGEST_ID else f"{name[: LONGEST_ID - 1]}…"


def indented(part: RenderableType, columns: int = 2) -> Padding:
    """Move a part in below its headline."""
    return Padding(part, (0, 0, 0, columns), expand=False)


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
        yield indented(Text(", ".join(path.name for path in case.files), "dim"))
    yield ""
    shapes = counted(facts.shapes, "shape")
    yield Text("Network", "bold")
    yield indented(
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
    yield indented(by_shape(rows) if len(rows) > MOST_ROWS and not everything else one_each(rows))
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
        yield indented(Text("no vehicles; also give route files"))
        yield ""
        return
    minutes = traffic.bar_s // 60
    drawn = " (drawn at random; these are of seed 0)" if traffic.random else ""
    yield indented(
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
                f"{clearance(case.timing)}",
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
    yield indented(Text.assemble((severity, _COLOUR[severity]), "  ", (f"{kind}{times}", "bold")))
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
