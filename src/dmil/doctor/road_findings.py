"""What is wrong or suspicious about roads, signals and programs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import combinations

from dmil.controllers.rules.shared_lanes import lanes_never_free, rivals_of_lanes
from dmil.doctor.case import Case, SumoFacts
from dmil.doctor.findings import Finding, Severity
from dmil.doctor.kinds import finding
from dmil.network import Intersection, Remark, RoadNetwork
from dmil.network.sumo.ways import reached
from dmil.scenarios.timing import advantages, signal_times

LONGEST_CYCLE_S = 180.0


def on_roads(case: Case) -> Iterator[Finding]:
    """Look for what is wrong or suspicious about the network (ours)."""
    if case.sumo:
        yield from _on_remarks(case, case.sumo)
        if case.network.left_hand:
            yield finding("left-hand-traffic", "network", "lefthand is true")
    for item in case.network.intersections:
        yield from _on_program(case, item)
        waiting = [walk for walk in item.walks if not walk.phases]
        if waiting:
            yield finding(
                "no-walk",
                f"intersection {item.id}",
                f"no phase gives green to {len(waiting)} of its {len(item.walks)} crossings",
            )
    for found in advantages(case.timing, case.network):
        item = case.network.intersections[found.intersection]
        yield finding("clearance-cut", f"intersection {item.id}", f"under a controller {found}")
    yield from _on_clearance_kind(case)
    yield from _on_links(case)


def _on_remarks(case: Case, facts: SumoFacts) -> Iterator[Finding]:
    """Turn the reader's remarks into findings, without the name of the file."""
    clashing = {
        item.id
        for item, signals in zip(case.network.intersections, facts.signals, strict=True)
        if _movements_clash(item, signals.states, signals.links)
    }
    for remark in facts.remarks:
        place = remark.where.partition(": ")[2] or remark.where
        mend = f"{remark.mend[0].upper()}{remark.mend[1:]}."
        if remark.kind == "single-action":
            mend = ""  # the remark names the reader's parameter, not the command's option
        severity: Severity | None = None
        if remark.kind == "conflicting-greens" and _controller(remark) not in clashing:
            severity = "warning"
        yield finding(remark.kind, place, remark.text, mend=mend, severity=severity)


def _controller(remark: Remark) -> str:
    return remark.where.rpartition("tlLogic ")[2]


def _movements_clash(
    item: Intersection, states: Iterable[str], links: tuple[tuple[int, ...], ...]
) -> bool:
    """Whether two movements that cross have G in one state, not just lanes of one movement."""
    return any(
        any(state[k] == "G" for k in links[i]) and any(state[k] == "G" for k in links[j])
        for state in states
        for i, j in item.conflicts
    )


def _on_program(case: Case, item: Intersection) -> Iterator[Finding]:
    place = f"intersection {item.id}"
    timing = case.timing
    junctions = case.sumo.junctions.get(item.id, 1) if case.sumo else 1
    all_red_s = case.sumo.all_red_s.get(item.id, 0.0) if case.sumo else 0.0
    if junctions > 1:
        yield finding(
            "several-junctions", place, f"its signal controller serves {junctions} junctions"
        )
    sharing = [j for j, rivals in enumerate(rivals_of_lanes(item)) if rivals]
    if sharing:
        yield finding(
            "shared-lanes",
            place,
            f"{len(sharing)} of its {len(item.movements)} movements share lanes with movements "
            "that have green in other phases",
        )
    locking = lanes_never_free(item)
    if locking:
        yield finding(
            "locking-lanes",
            place,
            f"no phase serves all movements of lane{'s' if len(locking) > 1 else ''} "
            f"{', '.join(locking)}",
        )
    if len(item.phases) == 1 and not case.sumo:  # of SUMO's the reader has said so
        yield finding("single-action", place, "it has one phase", mend="Give it more phases.")
    if item.program is None:
        if not item.own_control:  # the reader has said so
            yield finding("no-program", place, "it has no fixed-time program")
        return
    if item.program.adaptive:
        yield finding("adaptive-program", place, "its program is actuated")
    if item.program.cycle_s > LONGEST_CYCLE_S:
        yield finding("long-cycle", place, f"its cycle is {item.program.cycle_s:g} s")
    if item.clearance_s >= timing.decision_interval_s:
        yield finding(
            "clearance-beyond-interval",
            place,
            f"its clearance is {item.clearance_s:g} s, the decision interval "
            f"{timing.decision_interval_s} s",
        )
    if all_red_s:
        yield finding("all-red", place, f"all is red for up to {all_red_s:g} s")
    stages = item.program.stages
    mixed = [
        str(k)
        for k, stage in enumerate(stages)
        if stage.clearance and stage.green - stages[k - 1].green
    ]
    if mixed:
        yield finding(
            "mixed-stage",
            place,
            f"in stage{'s' if len(mixed) > 1 else ''} {', '.join(mixed)} of its program have green "
            "and yellow at once",
        )


def _on_clearance_kind(case: Case) -> Iterator[Finding]:
    """Compare the kind of clearance that is given with that of each plan, where it matters."""
    kind, times = case.timing.clearance_kind, signal_times(case.timing, case.network)
    for i, item in enumerate(case.network.intersections):
        plans = "all-stop" if item.all_stop else "kept"
        keeps = any(one & other for one, other in combinations(item.phases, 2))
        if kind in (None, plans) or item.program is None or not keeps:
            continue
        if times.clearance_s[i].any():
            what = f"under a controller clearance is {kind}, {plans} in its plan"
            yield finding("clearance-kind", f"intersection {item.id}", what)


def _on_links(case: Case) -> Iterator[Finding]:
    network = case.network
    space_m = case.dynamics.vehicle_space_m
    signalled = network.intersection_index
    crossed = {junction.id for junction in network.junctions} | signalled.keys()
    for index, link in enumerate(network.links):
        if link.end in crossed and not network.successors[index]:
            yield finding(
                "dead-end", f"link {link.id}", f"no movement leads out of it at node {link.end}"
            )
        if link.end in signalled and 0 < link.length_m < space_m:
            yield finding(
                "short-link",
                f"link {link.id}",
                f"it is {link.length_m:.1f} m long, a queued vehicle {space_m:.1f} m",
            )
    yield from _on_reach(network)


def _on_reach(network: RoadNetwork) -> Iterator[Finding]:
    forward = [[link for link, _ in pairs] for pairs in network.successors]
    backward: list[list[int]] = [[] for _ in forward]
    for index, following in enumerate(forward):
        for onto in following:
            backward[onto].append(index)
    for ends, ways, what in (
        (network.entry_links, forward, "not reachable from any entry"),
        (network.exit_links, backward, "no exit is reachable from it"),
    ):
        connected = {*ends, *reached(ends, ways)}
        if ends:
            for index, link in enumerate(network.links):
                if index not in connected:
                    yield finding("unreachable-link", f"link {link.id}", what)
