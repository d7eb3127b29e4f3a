"""Fixed-time plans as signal programs that SUMO loads as an additional file."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple
from xml.sax.saxutils import quoteattr

from dmil.network import Intersection, RoadNetwork
from dmil.network.sumo import SumoSignals
from dmil.scenarios import SignalTimes
from dmil.simulation.sumo.signals import cleared, going_on, setting_out, stopped

PROGRAM_ID = "dmil"


class Plan(NamedTuple):
    """Phases of one intersection in their order, with their seconds of green."""

    phases: tuple[int, ...]
    green_s: tuple[int, ...]


Timetable = Sequence[tuple[int, Sequence[Plan]]]
"""(second of the run, plan of every intersection), the first from second 0 on."""


def programs_xml(
    timetable: Timetable,
    network: RoadNetwork,
    signals: Sequence[SumoSignals],
    times: SignalTimes,
    begin_s: int,
) -> str:
    """Return plans for SUMO; loaded last, they are what its signals show (SUMO's documentation).

    Several plans are switched between by a WAUT, SUMO's timetable of programs. The offset of an
    intersection's own program is kept; without one a cycle begins with its plan. ``begin_s`` is
    SUMO's second that is second 0.
    """
    names = [PROGRAM_ID if k == 0 else f"{PROGRAM_ID}-{k}" for k in range(len(timetable))]
    lines = ["<additional>"]
    # The last one loaded is shown first.
    for name, (since_s, here) in reversed(list(zip(names, timetable, strict=True))):
        for i, (heads, plan) in enumerate(zip(signals, here, strict=True)):
            own = network.intersections[i].program
            begins_s = own.offset_s if own else begin_s + since_s
            lines.append(
                f'  <tlLogic id={quoteattr(heads.id)} type="static" programID="{name}"'
                f' offset="{begins_s:g}">'
            )
            lines += [
                f'    <phase duration="{duration_s}" state="{state}"/>'
                for duration_s, state in stages(heads, plan, times, network.intersections[i], i)
            ]
            lines.append("  </tlLogic>")
    if len(timetable) > 1:
        lines.append(f'  <WAUT id="{PROGRAM_ID}" refTime="0" startProg="{names[0]}">')
        for name, (since_s, _) in list(zip(names, timetable, strict=True))[1:]:
            lines.append(f'    <wautSwitch time="{begin_s + since_s}" to="{name}"/>')
        lines.append("  </WAUT>")
        lines += [
            f'  <wautJunction wautID="{PROGRAM_ID}" junctionID={quoteattr(heads.id)}/>'
            for heads in signals
        ]
    return "\n".join([*lines, "</additional>", ""])


def stages(
    heads: SumoSignals, plan: Plan, times: SignalTimes, item: Intersection, i: int
) -> list[tuple[int, str]]:
    """Return seconds and state of every stage of a plan, clearance included (ours).

    A green with pedestrians is long enough for them; ``i`` is the intersection's index.
    """
    found = []
    turns = pairwise([*plan.phases, plan.phases[0]])
    for green_s, (before, after) in zip(plan.green_s, turns, strict=True):
        old, new = heads.states[before], heads.states[after]
        if old == new:
            found.append((green_s, old))
        else:
            since_s = 0
            for end_s, letters in setting_out(heads, green_s, times, item, i, before):
                found.append((end_s - since_s, old))
                old, since_s = stopped(old, letters), end_s
            if green_s > since_s:
                found.append((green_s - since_s, old))
            all_red_s = int(times.all_red_s[i, before, after])
            yellow_s = int(times.clearance_s[i, before, after]) - all_red_s
            between = ((yellow_s, "y"), (all_red_s, "r"))
            staying = going_on(heads, item.unsignalled) if times.all_stop[i] else None
            found += [(s, cleared(old, new, losing, staying)) for s, losing in between if s]
    return found
