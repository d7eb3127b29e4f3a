"""``dmil doctor``: what was understood of a network and its demand, and what is wrong with them."""

from __future__ import annotations

from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Annotated, Any, get_args

import typer

from dmil.cli.application import FAILED
from dmil.cli.doctor_text import demand_text, findings_text, intersection_text, network_text
from dmil.cli.options import OUTPUT, Debug, Json, option
from dmil.cli.parameters import split
from dmil.cli.terminal import print_json, say, show
from dmil.doctor import Diagnosis, Finding, IntersectionFacts, examine, read_case
from dmil.errors import InputError
from dmil.network.sumo.reader import Phases
from dmil.scenarios.model import LONGEST_RUN_S, Routing

ELLIPSIS = "…"


_scenario = partial(option, "Scenario")


def doctor(
    files: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[FILES]",
            help="A .sumocfg; a .net.xml with its route files; a CityFlow folder; or the name of "
            "a scenario.",
            show_default=False,
        ),
    ] = None,
    scenario: Annotated[str | None, _scenario("Same as a name among FILES.", "NAME")] = None,
    net: Annotated[str | None, _scenario("Same as a network among FILES.", "FILE")] = None,
    routes: Annotated[
        str | None, _scenario("Same as route files among FILES.", "FILE,FILE")
    ] = None,
    roadnet: Annotated[
        Path | None, _scenario("Road network in CityFlow format, under any name.", "FILE")
    ] = None,
    flow: Annotated[
        Path | None, _scenario("Vehicles in CityFlow format, on that network.", "FILE")
    ] = None,
    begin: Annotated[
        int | None,
        _scenario(
            "SUMO time at which a run begins, in s; by default that of the configuration, or 0.",
            "N",
            min=0,
            max=LONGEST_RUN_S,
        ),
    ] = None,
    steps: Annotated[
        int | None,
        _scenario(
            "Length of a run in s; by default until the configuration's end, or until the last "
            "departure.",
            "N",
            min=1,
            max=LONGEST_RUN_S,
        ),
    ] = None,
    phases: Annotated[
        str | None,
        _scenario(
            "Phases of a SUMO network: those of its signal programs (the default), or "
            "derived from movements that do not conflict.",
            "program|derived",
        ),
    ] = None,
    routing: Annotated[
        str | None,
        _scenario(
            "Routing of trips without a route: by one run of SUMO with congestion, by "
            "the same with its mesoscopic model in a tenth of the time (the default "
            "where it is installed), or the fastest route on empty roads.",
            "sumo|mesoscopic|free-flow",
        ),
    ] = None,
    intersection: Annotated[
        str | None, option(OUTPUT, "Show one intersection; the start of its id is enough.", "ID")
    ] = None,
    everything: Annotated[
        bool, option(OUTPUT, "Print every intersection and finding.", flag="--all")
    ] = False,
    draw: Annotated[
        Path | None,
        option(
            OUTPUT,
            "Draw the network, or the intersection and its phases, to a file: .svg, .png, "
            ".pdf or .html.",
            "FILE",
        ),
    ] = None,
    strict: Annotated[
        bool,
        option(OUTPUT, "Exit with code 1 if there are errors or warnings.", flag="--strict"),
    ] = False,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Check a network and its demand: what was read, and what is wrong.

    For example:
        dmil doctor city.sumocfg
        dmil doctor city.net.xml city.rou.xml --begin 25200 --draw city.svg
        dmil doctor resco/cologne3 --intersection 360082 --draw phases.png
        dmil doctor FOLDER --strict

    First come the contents: roads, intersections with approaches, phases and programs, which of
    them share a shape (and may share a memory), departures over time, and whether the signals can
    serve the demand. Then come findings, each with a fix: errors make results wrong, warnings make
    them doubtful, notes are informative. docs/doctor.md explains all of them.

    Load is the degree of saturation of an intersection in the busiest 15 minutes, at optimal green
    splits and a cycle of 120 s. From 100 % on, queues grow under every controller. Yielding
    vehicles count as if unopposed, so real loads are somewhat higher.
    """
    named = [each for each in (scenario, net) if each] + split(routes or "")
    named += [str(file) for file in (roadnet, flow) if file]
    case = read_case(
        [*(files or ()), *named],
        begin_s=begin,
        horizon_s=steps,
        phases=_one_of(Phases, phases, "--phases"),
        routing=_one_of(Routing, routing, "--routing"),
    )
    diagnosis = examine(case)
    chosen = None if intersection is None else _chosen(diagnosis, intersection)
    if draw is not None:
        _draw(diagnosis, chosen, draw)
    findings = diagnosis.findings if chosen is None else _about(diagnosis, chosen)
    if json:
        print_json(_as_json(diagnosis, chosen, findings) | {"drawing": draw})
    else:
        _print(diagnosis, chosen, findings, everything)
        if draw is not None:
            say(f"Drawing: {draw}")
    if strict and any(each.severity != "note" for each in findings):
        raise typer.Exit(FAILED)


def _one_of(names: Any, given: str | None, option: str) -> Any:
    if given is None or given in get_args(names):
        return given
    expected = f"one of {', '.join(sorted(get_args(names)))}"
    raise InputError(f"found '{given}'", where=option, expected=expected)


def _chosen(diagnosis: Diagnosis, wanted: str) -> IntersectionFacts:
    """Find an intersection by its id or the beginning of it."""
    begin = wanted.rstrip(ELLIPSIS)
    exact = [each for each in diagnosis.intersections if each.id == wanted]
    found = exact or [each for each in diagnosis.intersections if each.id.startswith(begin)]
    if len(found) == 1:
        return found[0]
    names = [each.id for each in found or diagnosis.intersections]
    more = f" and {len(names) - 20} more" if len(names) > 20 else ""
    raise InputError(
        f"{len(found)} intersections begin with '{begin}'"
        if found
        else f"there is no intersection '{begin}'",
        where="--intersection",
        expected=f"one of {', '.join(names[:20])}{more}",
    )


def _about(diagnosis: Diagnosis, chosen: IntersectionFacts) -> tuple[Finding, ...]:
    places = tuple(f"{kind} {chosen.id}" for kind in ("intersection", "tlLogic", "junction"))
    return tuple(
        each
        for each in diagnosis.findings
        if any(each.place == place or each.place.startswith(f"{place},") for place in places)
    )


def _draw(diagnosis: Diagnosis, chosen: IntersectionFacts | None, path: Path) -> None:
    from dmil.reports import save_figure
    from dmil.reports.intersection_chart import intersection_chart
    from dmil.reports.network_chart import network_chart

    chart = (
        network_chart(diagnosis)
        if chosen is None
        else intersection_chart(diagnosis, diagnosis.intersections.index(chosen))
    )
    save_figure(chart, path)


def _print(
    diagnosis: Diagnosis,
    chosen: IntersectionFacts | None,
    findings: tuple[Finding, ...],
    everything: bool,
) -> None:
    if chosen is not None:
        show(*intersection_text(chosen))
    else:
        show(*network_text(diagnosis, everything))
        show(*demand_text(diagnosis))
    show(*findings_text(findings, everything or chosen is not None))


def _as_json(
    diagnosis: Diagnosis, chosen: IntersectionFacts | None, findings: tuple[Finding, ...]
) -> dict[str, Any]:
    case, traffic = diagnosis.case, diagnosis.traffic
    demand = asdict(traffic) if traffic else None
    if demand:
        # They stand with the intersections and findings.
        for name in ("load", "crossing", "entries_veh_per_s", "ends"):
            del demand[name]
    shown = diagnosis.intersections if chosen is None else [chosen]
    return {
        "name": case.name,
        "files": list(case.files),
        "begin_s": case.begin_s,
        "horizon_s": case.horizon_s,
        "timing": case.timing.model_dump(),
        "network": asdict(diagnosis.network),
        "intersections": [asdict(each) for each in shown],
        "demand": demand,
        "findings": [asdict(each) for each in findings],
    }
