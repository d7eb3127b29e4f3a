"""Fixed-time plans as signal programs that SUMO loads as an additional file."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple
from xml.sax.saxutils import quoteattr

from dmil.files import write_text_atomically
from dmil.network.sumo import SumoSignals
from dmil.scenarios import SignalTiming
from dmil.simulation.sumo.signals import cleared

PROGRAM_ID = "dmil"


class Plan(NamedTuple):
    """Phases of one intersection in their order, with their seconds of green."""

    phases: tuple[int, ...]
    green_s: tuple[int, ...]


def write_programs(
    file: Path,
    plans: Sequence[tuple[int, Sequence[Plan]]],
    signals: Sequence[SumoSignals],
    timing: SignalTiming,
    begin_s: int,
) -> None:
    """Write plans for SUMO; loaded last, they are what its signals show (SUMO's documentation).

    Between two phases stand the yellow and all-red of the signal timing. Several plans are switched
    between by a WAUT, SUMO's timetable of programs.

    Parameters
    ----------
    file
        Where to, such as ``programs.add.xml``.
    plans
        (second of the run, plan of every intersection), the first from second 0 on.
    signals
        How SUMO shows the phases, one per intersection.
    timing
        Its clearance.
    begin_s
        SUMO's second that is second 0.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    names = [PROGRAM_ID if k == 0 else f"{PROGRAM_ID}-{k}" for k in range(len(plans))]
    lines = ["<additional>"]
    # The last one loaded is shown first.
    for name, (since_s, here) in reversed(list(zip(names, plans, strict=True))):
        for heads, plan in zip(signals, here, strict=True):
            lines.append(
                f'  <tlLogic id={quoteattr(heads.id)} type="static" programID="{name}"'
                f' offset="{begin_s + since_s}">'
            )
            lines += [
                f'    <phase duration="{duration_s}" state="{state}"/>'
                for duration_s, state in stages(heads, plan, timing)
            ]
            lines.append("  </tlLogic>")
    if len(plans) > 1:
        lines.append(f'  <WAUT id="{PROGRAM_ID}" refTime="0" startProg="{names[0]}">')
        for name, (since_s, _) in list(zip(names, plans, strict=True))[1:]:
            lines.append(f'    <wautSwitch time="{begin_s + since_s}" to="{name}"/>')
        lines.append("  </WAUT>")
        lines += [
            f'  <wautJunction wautID="{PROGRAM_ID}" junctionID={quoteattr(heads.id)}/>'
            for heads in signals
        ]
    write_text_atomically(file, "\n".join([*lines, "</additional>", ""]))


def stages(heads: SumoSignals, plan: Plan, timing: SignalTiming) -> list[tuple[int, str]]:
    """Return seconds and state of every stage of a plan, clearance included (ours).

    Parameters
    ----------
    heads, plan
        Of one intersection.
    timing
        Its clearance.
    """
    states = [heads.states[phase] for phase in plan.phases]
    yellow_s = timing.clearance_s - timing.all_red_s
    found = []
    for green_s, (before, after) in zip(plan.green_s, pairwise([*states, states[0]]), strict=True):
        found.append((green_s, before))
        if before != after:
            between = ((yellow_s, "y"), (timing.all_red_s, "r"))
            found += [(s, cleared(before, after, losing)) for s, losing in between if s]
    return found
