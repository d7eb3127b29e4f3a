"""What the doctor says on a terminal of 80 columns."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby

from rich import box
from rich.console import RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from dmil.cli.terminal import entries
from dmil.doctor import Diagnosis, Finding, IntersectionFacts
from dmil.doctor.kinds import Severity

MOST_ROWS = 24
"""Networks of more intersections are summarised by shape."""
DETAILED = 3
"""Networks of up to so many intersections show all of each."""
MOST_EXAMPLES = 3
LONGEST_ID, LONGEST_WORD, ROADS_WIDTH = 21, 48, 15
FULL, BUSY = 1.0, 0.85
_BARS = "▁▂▃▄▅▆▇█"
_LETTER = {"right": "R", "straight": "F", "left": "L", "uturn": "U"}
_COLOUR: dict[Severity, str] = {"error": "bold red", "warning": "yellow", "note": "cyan"}


def network_text(diagnosis: Diagnosis, everything: bool) -> Iterator[RenderableType]:
    """Say what the network is (ours).

    Parameters
    ----------
    diagnosis
        What was understood.
    everything
        Whether every intersection is shown whole.
    """
    facts, case = diagnosis.network, diagnosis.case
    yield Text(case.name, "bold")
    if case.files:
        yield _inside(Text(", ".join(path.name for path in case.files), "dim"))
    yield ""
    shapes = _count(facts.shapes, "shape")
    yield Text("Network", "bold")
    yield _inside(
        entries(
            {
                "roads": f"{_count(facts.links, 'link')}, {facts.road_km:.1f} km "
                f"({facts.lane_km:.1f} km of lanes), {facts.slowest_km_per_h:.0f} to "
                f"{facts.fastest_km_per_h:.0f} km/h",
                "signals": f"{_count(facts.intersections, 'intersection')} of {shapes}; "
                "those of one shape may share a memory",
                "other nodes": f"{_count(facts.junctions, 'junction')} without signals, "
                f"{facts.fringe} where vehicles come and go",
            }
        )
    )
    yield ""
    rows = diagnosis.intersections
    yield Text("Intersections", "bold")
    yield _inside(_by_shape(rows) if len(rows) > MOST_ROWS and not everything else _one_each(rows))
    if everything or len(rows) <= DETAILED:
        yield ""
        for each in rows:
            yield from intersection_text(each)
    else:
        yield ""


def intersection_text(item: IntersectionFacts) -> Iterator[RenderableType]:
    """Say all about one intersection (ours).

    Parameters
    ----------
    item
        What was understood of it.
    """
    alike = "none" if item.alike == 1 else str(item.alike - 1)
    yield Text(f"Intersection {item.id}", "bold")
    lines = {
        "shape": f"{item.shape}; {alike} other{'s' if item.alike > 2 else ''} of this shape; "
        f"symmetry group of {item.symmetries}",
        "movements": f"{item.movements}"
        + (f"; always may go: {item.unsignalled}" if item.unsignalled else ""),
    }
    if item.junctions > 1:
        lines["junctions"] = f"{item.junctions} under one controller"
    if item.program_kind:
        lines["own program"] = _program(item)
    if item.load:
        lines["load"] = _load_text(item)
    yield _inside(entries(lines))
    yield ""
    yield _inside(_approaches(item))
    yield ""
    yield _inside(_phases(item))
    yield ""


def demand_text(diagnosis: Diagnosis) -> Iterator[RenderableType]:
    """Say who drives, when, and whether the signals can serve it (ours).

    Parameters
    ----------
    diagnosis
        What was understood.
    """
    traffic, case = diagnosis.traffic, diagnosis.case
    yield Text("Demand", "bold")
    if traffic is None:
        yield _inside(Text("no vehicles; give route files, too"))
        yield ""
        return
    minutes = traffic.bar_s // 60
    drawn = " (drawn at random; these are of seed 0)" if traffic.random else ""
    yield _inside(
        entries(
            {
                "vehicles": f"{traffic.vehicles:,}, from {_time(traffic.first_s)} to "
                f"{_time(traffic.last_s)}{drawn}",
                "departures": f"{sparkline(traffic.departures)}  {min(traffic.departures)} to "
                f"{max(traffic.departures)} per {f'{minutes} min' if minutes > 1 else 'min'}",
                "routes": f"{traffic.length_m:.0f} m and {traffic.links:.1f} links in the mean, "
                f"{traffic.free_flow_s:.0f} s without delay",
                "signals": f"{traffic.signalled_share:.0%} of the vehicles pass one; "
                f"{traffic.signals_passed:.1f} in the mean",
                "run": f"{_time(case.begin_s)} to {_time(case.begin_s + case.horizon_s)}; a "
                f"decision every {case.timing.decision_interval_s} s, clearance "
                f"{case.timing.clearance_s} s",
                "can it be served?": _verdict(diagnosis),
            }
        )
    )
    yield ""


def findings_text(findings: Sequence[Finding], everything: bool) -> Iterator[RenderableType]:
    """List findings with their mends, those of one kind together (ours).

    Parameters
    ----------
    findings
        Sorted by severity and kind.
    everything
        Whether to show more than a few of each kind.
    """
    if not findings:
        yield Text("Nothing found that is wrong or suspicious.", "green")
        return
    counts = [
        _count(sum(each.severity == severity for each in findings), severity)
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
    yield _inside(Text.assemble((severity, _COLOUR[severity]), "  ", (f"{kind}{times}", "bold")))
    shown = group if everything else group[:MOST_EXAMPLES]
    mends = {each.mend for each in shown}
    for each in shown:
        place = each.place if everything else " ".join(map(_cut, each.place.split(" ")))
        yield _indented(Text(f"{place}: {each.what}", overflow="fold"), 4)
        if len(mends) > 1:
            yield _indented(Text(f"→ {each.mend}", "dim", overflow="fold"), 6)
    if len(group) > len(shown):
        yield _indented(Text(f"and {len(group) - len(shown)} more (--all)", "dim"), 4)
    if len(mends) == 1:
        yield _indented(Text(f"→ {group[0].mend}", "dim", overflow="fold"), 4)


def sparkline(counts: Sequence[int]) -> str:
    """Draw numbers as bars of text, from 0 to the largest (ours).

    Parameters
    ----------
    counts
        Numbers of 0 or more.
    """
    most = max(counts, default=0) or 1
    return "".join(_BARS[round((len(_BARS) - 1) * count / most)] for count in counts)


def _one_each(rows: Sequence[IntersectionFacts]) -> Table:
    table = _table("id", "shape", "roads in", "moves", "phases", "sym", *_plan_heads(rows), gap=0)
    table.columns[2].min_width = min(ROADS_WIDTH, max(len(_lanes(item)) for item in rows))
    for item in rows:
        table.add_row(
            _short(item.id), item.shape, _lanes(item), *_figures(item), *_plan(item, rows)
        )
    return table


def _by_shape(rows: Sequence[IntersectionFacts]) -> Table:
    table = _table(
        "shape", "number", "such as", "moves", "phases", "sym", *_plan_heads(rows), gap=0
    )
    for shape in dict.fromkeys(item.shape for item in rows):
        same = [item for item in rows if item.shape == shape]
        busiest = max(same, key=lambda item: item.load.degree if item.load else 0.0)
        table.add_row(
            shape, str(len(same)), _short(busiest.id), *_figures(busiest), *_plan(busiest, rows)
        )
    return table


def _figures(item: IntersectionFacts) -> tuple[str, str, str]:
    return str(item.movements), str(len(item.phases)), str(item.symmetries)


def _plan_heads(rows: Sequence[IntersectionFacts]) -> list[str]:
    heads = ["cycle"] if any(item.program_kind for item in rows) else []
    if any(item.load for item in rows):
        heads += ["load"]
        if any(item.load and item.load.program_degree is not None for item in rows):
            heads += ["plan"]
    return heads


def _plan(item: IntersectionFacts, rows: Sequence[IntersectionFacts]) -> list[str | Text]:
    cells: dict[str, str | Text] = {
        "cycle": f"{item.cycle_s:.0f} s" if item.program_kind else "–",
        "load": _percent(item.load.degree if item.load else None),
        "plan": _percent(item.load.program_degree if item.load else None),
    }
    return [cells[head] for head in _plan_heads(rows)]


def _percent(share: float | None) -> Text:
    if share is None:
        return Text("–")
    style = "bold red" if share > FULL else "yellow" if share > BUSY else ""
    return Text(f"{share:.0%}" if share < 10 else "> 999%", style)


def _lanes(item: IntersectionFacts) -> str:
    between = ":" if item.approaches[0].name.isdigit() else ""
    return " ".join(f"{each.name}{between}{each.lanes}" for each in item.approaches)


def _approaches(item: IntersectionFacts) -> Table:
    table = _table("from", "link", "lanes", "length", "turns (lanes)")
    for each in item.approaches:
        turns = ", ".join(f"{_LETTER[turn]} {lanes}" for turn, lanes in each.turns)
        table.add_row(
            each.name, _short(each.link), str(each.lanes), f"{each.length_m:.0f} m", turns
        )
    return table


def _phases(item: IntersectionFacts) -> Table:
    heads = ["phase", "serves"]
    heads += ["green"] if item.program_kind else []
    heads += ["vehicles", "time needed"] if item.load else []
    table = _table(*heads)
    for index, phase in enumerate(item.phases):
        row: list[str | Text] = [str(index), phase.name]
        if item.program_kind:
            row.append("–" if phase.planned_green_s is None else f"{phase.planned_green_s:g} s")
        if item.load:
            row += [str(phase.vehicles), _percent(phase.load)]
        table.add_row(*row)
    return table


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
    assert item.load is not None, "it is asked for only where there is one"
    if not item.vehicles:
        return "no vehicle passes it"
    own = item.load.program_degree
    planned = "" if own is None else f"; own program {_percent(own).plain}"
    return (
        f"{item.vehicles} vehicles pass; in the busiest 15 min {item.load.degree:.0%} of its time"
        f"{planned}"
    )


def _verdict(diagnosis: Diagnosis) -> Text:
    loads = {item.id: item.load.degree for item in diagnosis.intersections if item.load}
    name = max(loads, key=loads.__getitem__)
    words, style = (
        ("no", "bold red")
        if loads[name] > FULL
        else ("hardly", "yellow")
        if loads[name] > BUSY
        else ("yes", "green")
    )
    return Text.assemble(
        (words, style),
        f": in its busiest 15 min intersection {_short(name)} needs {loads[name]:.0%} of its time",
    )


def _time(seconds: int) -> str:
    if seconds < 3600:
        return f"{seconds} s"
    minutes, rest = divmod(seconds, 60)
    hours, minutes = divmod(minutes, 60)
    return f"{seconds} s ({hours}:{minutes:02d}:{rest:02d})"


def _count(number: int, name: str) -> str:
    return f"{number:,} {name}{'' if number == 1 else 's'}"


def _short(name: str) -> str:
    return name if len(name) <= LONGEST_ID else f"{name[: LONGEST_ID - 1]}…"


def _cut(word: str) -> str:
    """Cut ids that would fill lines; the beginning of one is enough for --intersection."""
    return word if len(word) <= LONGEST_WORD else _short(word)


def _inside(part: RenderableType) -> Padding:
    return _indented(part, 2)


def _indented(part: RenderableType, columns: int) -> Padding:
    return Padding(part, (0, 0, 0, columns), expand=False)


def _table(*heads: str, gap: int = 1) -> Table:
    left = ("id", "roads in", "such as", "from", "link", "serves", "turns (lanes)", "shape")
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, padding=(0, gap, 0, 0))
    for head in heads:
        flows = head in ("serves", "turns (lanes)", "roads in")
        table.add_column(
            head,
            justify="left" if head in left else "right",
            no_wrap=not flows,
            overflow="fold",
        )
    return table
