"""Rules between what a controller asks for and what the signals show.

Minimum and maximum green, clearance time and start-up lost time are worked out here and nowhere
else, once per decision and for every simulator; the queue simulator only compares the time with
``go_from_s``, SUMO is told the states that follow from it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dmil.arrays import BoolArray, IntArray
from dmil.compilation import kernel
from dmil.errors import InputError
from dmil.network import RoadNetwork
from dmil.scenarios import SignalTiming, signal_times
from dmil.simulation.stand_ins import stand_in

NEVER_S = np.iinfo(np.int32).max
"""``go_from_s`` of a movement that has red."""

PROGRAM = -1
"""Asked for in place of a phase: the intersection's own fixed-time program."""

ACTUATED = -2
"""Asked for in place of a phase: SUMO's actuated control of that program; SUMO only."""


class Rules(NamedTuple):
    """Signal timing for kernels, in whole seconds.

    Attributes
    ----------
    decision_interval_s: int
    startup_lost_s: int
    clearance_s: (intersections, phases, phases) int32
        Of the change from a phase (row) to another (column).
    min_green_s, max_green_s: (intersections, phases) int32
        Of a phase; a longest green of 0 is no limit.
    all_stop: (intersections,) bool
        Whether clearance stops those too who have green before and after it.
    """

    decision_interval_s: int
    startup_lost_s: int
    clearance_s: IntArray
    min_green_s: IntArray
    max_green_s: IntArray
    all_stop: BoolArray


class Signals(NamedTuple):
    """Who may go in which phase.

    Attributes
    ----------
    phase_count: (intersections,) int32
    served: (intersections, phases, movements) bool
        Who may go in a phase, the unsignalled movements included.
    unsignalled: (intersections, movements) bool
        Who may always go.
    """

    phase_count: IntArray
    served: BoolArray
    unsignalled: BoolArray


class Programs(NamedTuple):
    """Fixed-time programs of all intersections, their stages one after the other.

    Attributes
    ----------
    offset: (intersections + 1,) int32
        Where the stages of an intersection begin; it has none without a program.
    end_s: (stages,) int32
        When a stage ends, counted from the beginning of the cycle.
    green: (stages, movements) bool
        Who may go, the unsignalled movements included.
    begin_s: (intersections,) int32
        Place in the cycle at time 0.
    """

    offset: IntArray
    end_s: IntArray
    green: BoolArray
    begin_s: IntArray


def rules_of(timing: SignalTiming, network: RoadNetwork) -> Rules:
    """Return the signal timing of a network's intersections for kernels (ours)."""
    times = signal_times(timing, network)
    return Rules(
        decision_interval_s=timing.decision_interval_s,
        startup_lost_s=timing.startup_lost_s,
        clearance_s=times.clearance_s,
        min_green_s=times.min_green_s,
        max_green_s=times.max_green_s,
        all_stop=times.all_stop,
    )


def signals_of(network: RoadNetwork) -> Signals:
    """Return who may go in which phase, for all intersections of a network (ours)."""
    intersections = network.intersections
    movements = max(len(item.movements) for item in intersections)
    phases = max(len(item.phases) for item in intersections)
    served = np.zeros((len(intersections), phases, movements), np.bool_)
    unsignalled = np.zeros((len(intersections), movements), np.bool_)
    for i, item in enumerate(intersections):
        unsignalled[i, list(item.unsignalled)] = True
        for p, phase in enumerate(item.phases):
            served[i, p, list(phase | item.unsignalled)] = True
    phase_count = np.array([len(item.phases) for item in intersections], np.int32)
    return Signals(phase_count, served, unsignalled)


def programs_of(network: RoadNetwork, start_s: int = 0) -> Programs:
    """Return the fixed-time programs of a network, stages rounded to whole seconds (ours).

    An intersection under a control that only SUMO can run gets a stand-in, see `stand_in`.

    Parameters
    ----------
    network
        The roads and signals.
    start_s
        Time of the programs at which a run begins.
    """
    movements = max(len(item.movements) for item in network.intersections)
    offset, ends, greens, begin = [0], [], [], []
    for item in network.intersections:
        stages = item.program.stages if item.program else stand_in(item)
        end_s = np.round(np.cumsum([stage.duration_s for stage in stages])).astype(int).tolist()
        if end_s:
            end_s[-1] = max(end_s[-1], 1)
        ends += end_s
        for stage in stages:
            green = np.zeros(movements, np.bool_)
            green[list(stage.green | item.unsignalled)] = True
            greens.append(green)
        offset.append(len(ends))
        late_s = item.program.offset_s if item.program else 0.0
        begin.append(round(start_s - late_s) % end_s[-1] if end_s else 0)
    return Programs(
        offset=np.array(offset, np.int32),
        end_s=np.array(ends, np.int32),
        green=np.array(greens, np.bool_).reshape(len(ends), movements),
        begin_s=np.array(begin, np.int32),
    )


def checked_phases(
    phases: npt.NDArray[np.integer],
    network: RoadNetwork,
    signals: Signals,
    lowest: IntArray,
    *,
    where: str,
) -> IntArray:
    """Return the phases that a controller chose, for kernels (ours).

    Parameters
    ----------
    phases: (intersections,) int
    network, signals
        What they are for.
    lowest: (intersections,) int
        Least number that may be asked for: 0, or less where a program can be followed.
    where
        Name of the scenario.

    Raises
    ------
    InputError
        If there is not one existing phase per intersection, or no program where one is asked for.
    """
    counts = signals.phase_count
    phases = np.asarray(phases)
    if phases.shape != counts.shape or phases.dtype.kind not in "iu":
        raise InputError(
            f"the controller chose phases of shape {phases.shape} and type {phases.dtype}",
            where=where,
            expected=f"one whole number for each of the {counts.size} intersections",
        )
    checked: IntArray = np.ascontiguousarray(phases, np.int32)
    if checked is phases or (checked == phases).all():
        i = first_wrong(checked, lowest, counts)
    else:
        i = int((checked != phases).argmax())
    if i < counts.size:
        item = network.intersections[i]
        raise InputError(
            f"the controller chose phase {phases[i]}",
            where=f"intersection '{item.id}'",
            expected=f"a phase from 0 to {counts[i] - 1}"
            + ("" if item.program else "; it has no program of its own"),
            mend="actuated control is SUMO's own: choose the simulator sumo"
            if phases[i] == ACTUATED and item.program
            else None,
        )
    return checked


@kernel
def first_wrong(phases: IntArray, lowest: IntArray, counts: IntArray) -> int:
    """Return the first intersection whose phase does not exist; their number if there is none."""
    i = 0
    while i < phases.shape[0] and lowest[i] <= phases[i] < counts[i]:
        i += 1
    return i


@kernel
def grant(
    signals: Signals,
    requested: IntArray,
    phase: IntArray,
    green_from_s: IntArray,
    go_from_s: IntArray,
    switch_s: IntArray,
    time_s: int,
    rules: Rules,
) -> int:
    """Turn requested phases into the phases shown; return how many requests were overruled (ours).

    A change is refused while a clearance runs or the green is younger than ``min_green_s``. A green
    of ``max_green_s`` or more is ended: if the controller does not, the next phase follows. A
    granted change begins with its ``clearance_s`` in which only movements go that are green in both
    phases, unless it is of the kind all-stop, and unsignalled ones; a movement that had to stop
    loses ``startup_lost_s`` more. The first phase of a run, and one after the intersection's own
    program, needs no clearance.

    Parameters
    ----------
    signals
        Who may go in which phase.
    requested, phase: (intersections,) int
        Phases wanted (`PROGRAM` for the intersection's own program) and shown (changed in place; −1
        before the first decision and under the own program).
    green_from_s: (intersections,) int32
        When the phase shown turned or turns green, changed in place.
    go_from_s: (intersections, movements) int32
        From when on vehicles of a movement go; `NEVER_S` for red. Changed in place.
    switch_s: (intersections,) int32
        When the own program switches next; `NEVER_S` if it is not in charge. Changed in place.
    time_s: int
    rules
        Signal timing.
    """
    served, unsignalled = signals.served, signals.unsignalled
    overruled = 0
    for i in range(phase.shape[0]):
        wanted, shown = requested[i], phase[i]
        if wanted == PROGRAM:
            if switch_s[i] == NEVER_S:
                phase[i] = -1
                green_from_s[i] = time_s
                switch_s[i] = time_s
            continue
        switch_s[i] = NEVER_S
        if wanted == shown:
            longest_s = rules.max_green_s[i, shown]
            too_long = longest_s > 0 and time_s >= green_from_s[i] + longest_s
            if not too_long or signals.phase_count[i] == 1:
                continue
            overruled += 1
            wanted = (wanted + 1) % signals.phase_count[i]
        elif shown >= 0 and time_s < green_from_s[i] + rules.min_green_s[i, shown]:
            overruled += 1
            continue
        green_from_s[i] = time_s if shown < 0 else time_s + rules.clearance_s[i, shown, wanted]
        phase[i] = wanted
        stops = rules.all_stop[i] and shown >= 0
        for j in range(served.shape[2]):
            if unsignalled[i, j]:
                go_from_s[i, j] = 0
            elif not served[i, wanted, j]:
                go_from_s[i, j] = NEVER_S
            elif stops or go_from_s[i, j] == NEVER_S:
                go_from_s[i, j] = green_from_s[i] + rules.startup_lost_s
    return overruled


@kernel
def follow_programs(
    programs: Programs,
    go_from_s: IntArray,
    switch_s: IntArray,
    time_s: int,
    startup_lost_s: int,
) -> int:
    """Let own programs that are due show their next stage; return when the next one is (ours).

    Parameters
    ----------
    programs
        All programs.
    go_from_s, switch_s
        See `grant`; changed in place.
    time_s, startup_lost_s: int
    """
    next_s = NEVER_S
    for i in range(switch_s.shape[0]):
        if switch_s[i] == NEVER_S:
            continue
        if switch_s[i] <= time_s:
            first, last = programs.offset[i], programs.offset[i + 1] - 1
            place_s = (time_s + programs.begin_s[i]) % programs.end_s[last]
            stage = first
            while programs.end_s[stage] <= place_s:
                stage += 1
            switch_s[i] = time_s + programs.end_s[stage] - place_s
            for j in range(go_from_s.shape[1]):
                if not programs.green[stage, j]:
                    go_from_s[i, j] = NEVER_S
                elif go_from_s[i, j] == NEVER_S:
                    go_from_s[i, j] = time_s + startup_lost_s
        next_s = min(next_s, switch_s[i])
    return next_s
