"""The plan that export writes: never less safe than the one that it replaces."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from dmil.errors import InputError
from dmil.files import write_text_atomically
from dmil.network import Intersection, RoadNetwork, SumoSignals
from dmil.network.sumo.suspicions import first_clash
from dmil.scenarios import SignalTiming
from dmil.scenarios.timing import safest_times
from dmil.simulation.sumo.programs import Plan, programs_xml, stages
from dmil.training.mean_cycle import MeanCycle


def write_plans(
    file: Path,
    plans: Sequence[tuple[int, Sequence[MeanCycle]]],
    network: RoadNetwork,
    timing: SignalTiming,
    signals: Sequence[SumoSignals],
    net_file: Path,
    begin_s: int,
) -> None:
    """Write mean cycles as SUMO's programs, once they are checked.

    Yellow, all-red and least greens are those of the run, or of the network's own plans where
    these are longer; so are the offsets, and the phase that a cycle begins with. Plans are (second
    of the run, cycle of every intersection); the matrices of ``net_file`` say which greens
    conflict; ``begin_s`` is SUMO's second that is second 0.

    Raises
    ------
    InputError
        If two movements that conflict would have the right of way at once.
    OutputError
        If the file cannot be written.
    """
    times = safest_times(timing, network)
    timetable = [
        (
            since_s,
            [
                _plan(item, cycle, times.min_green_s[i].tolist())
                for i, (item, cycle) in enumerate(zip(network.intersections, cycles, strict=True))
            ],
        )
        for since_s, cycles in plans
    ]
    items = network.intersections
    shown = {
        heads.id: [
            state
            for _, here in timetable
            for _, state in stages(heads, here[i], times, items[i], i)
        ]
        for i, heads in enumerate(signals)
    }
    clash = first_clash(net_file, shown)
    if clash:
        raise InputError(
            str(clash),
            where=f"the plan of signal '{clash.signal}', which was not written",
            expected="no conflicting greens (<request foes> of the network)",
            mend="in the network's own program, write g for the yielding movement, or r; or use "
            "--phases derived",
        )
    write_text_atomically(file, programs_xml(timetable, network, signals, times, begin_s))


def _plan(item: Intersection, cycle: MeanCycle, least_s: Sequence[int]) -> Plan:
    """Return a cycle that begins as the intersection's own plan does, no green too short."""
    own = item.program.stages if item.program else ()
    first = next(
        (
            cycle.phases.index(phase)
            for stage in own
            if not stage.clearance and stage.green in item.phases
            if (phase := item.phases.index(stage.green)) in cycle.phases
        ),
        0,
    )
    turns = [
        (phase, max(green_s, least_s[phase]))
        for phase, green_s in zip(cycle.phases, cycle.green_s, strict=True)
    ]
    phases, green_s = zip(*turns[first:], *turns[:first], strict=True)
    return Plan(phases, green_s)
