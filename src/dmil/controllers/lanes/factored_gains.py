"""What phases gain by the factored memory, compiled: all intersections at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dmil.arrays import ByteArray, FloatArray, IntArray, Single
from dmil.compilation import kernel
from dmil.controllers.lanes.lane_groups import Indices, LaneGroups
from dmil.controllers.lanes.lane_inputs import (
    ONE,
    PARTLY,
    RED,
    STATE_BINS,
    ZERO,
    Inputs,
    LaneScratch,
    Real,
    ShortTerm,
    Whole,
    green_part,
    served_wholly,
    state_bin,
)
from dmil.controllers.lanes.movement_facts import Movements
from dmil.controllers.lanes.movements import (
    note_vehicles,
    owed_in_phase,
    shown_phase,
    treat,
)
from dmil.memory.residuals import ResidualTable

RATE_EDGES_VEH = tuple(np.float32(edge) for edge in (0.15, 0.4, 0.8, 1.5, 3.0))
"""Arrival rates between these have a row of their own."""
RATES = len(RATE_EDGES_VEH) + 1
ROWS = STATE_BINS * RATES
TIE, TIE_PART = np.float32(2e-4), np.float32(4e-7)
"""Sums of gains that ought to be equal differ by less, or by less than this part of them."""


class FactoredParams(NamedTuple):
    """Numbers for the kernel: see `FactoredSettings`, and `LaneMemory` for ``after_switch``."""

    vehicle: float
    expected: float
    wave: float
    after_switch: float
    discount: float
    trust: float
    trust_veh: float
    rate_step: float
    age: float
    approaching: bool
    rates: bool
    learning: bool


class Gains(NamedTuple):
    """Working space of the choice.

    Attributes
    ----------
    learned_more: (rows, columns) float32
        What was learned of a treatment, less what was learned of red.
    treatment: (ways, groups) uint8
        How a group would be treated, served wholly or in part.
    learned: (groups,) float32
        What was learned of a group that would be treated so.
    gain: (ways * groups + 2,) float32
        What green gains over red, for all lanes of a group; at the end what serving no group gains,
        and the phase that does not exist.
    total, highest: (most phases, intersections), (intersections,) float32
        What a phase gains; the most.
    error: (groups,) float32
        Error of the last prediction by the prior alone.
    movements: Movements
        What tells movements apart.
    """

    learned_more: Single
    treatment: ByteArray
    learned: Single
    gain: Single
    total: Single
    highest: Single
    error: Single
    movements: Movements


def make_gains(groups: LaneGroups, movements: Movements, columns: int) -> Gains:
    """Return working space for a network and so many ways to treat a lane."""
    count, (_, phases, agents) = groups.lanes.size, groups.served_block.shape
    gain = np.zeros(groups.ways * count + 2, np.float32)
    gain[-1] = -np.inf
    return Gains(
        learned_more=np.zeros((ROWS, columns), np.float32),
        treatment=np.full((groups.ways, count), PARTLY, np.uint8),
        learned=np.zeros(count, np.float32),
        gain=gain,
        total=np.zeros((phases, agents), np.float32),
        highest=np.zeros(agents, np.float32),
        error=np.zeros(count, np.float32),
        movements=movements,
    )


@kernel
def look_up(after_switch: float, table: ResidualTable, scratch: LaneScratch, gains: Gains) -> None:
    """Prepare what was learned and how phases may treat groups, after `note_shown`."""
    for row in range(gains.learned_more.shape[0]):
        for treatment in range(1, gains.learned_more.shape[1]):
            more = table.residual[row, treatment] - table.residual[row, RED]
            gains.learned_more[row, treatment] = more
    for g in range(scratch.shown.shape[0]):
        gains.treatment[0, g] = served_wholly(scratch.shown[g], after_switch)


@kernel
def _weigh(
    groups: LaneGroups, params: FactoredParams, short: ShortTerm, scratch: LaneScratch, gains: Gains
) -> None:
    """Find the rows of all groups, and what each gains from green."""
    count, row, learned = groups.lanes.shape[0], scratch.row, gains.learned
    used = ONE if params.rates else ZERO
    for g in range(count):
        row[g] = _row(scratch.queue_veh[g], scratch.expected_veh[g], used * short.rate_veh[g])
    vehicle, after_switch = np.float32(params.vehicle), np.float32(params.after_switch)
    trust, trust_veh = np.float32(params.trust), np.float32(params.trust_veh)
    for way in range(gains.treatment.shape[0]):
        treatment, gain = gains.treatment[way], gains.gain[way * count : (way + 1) * count]
        for g in range(count):
            learned[g] = gains.learned_more[row[g], treatment[g]]
        for g in range(count):
            waiting_veh = scratch.queue_veh[g] + scratch.expected_veh[g]
            believed = vehicle * waiting_veh * green_part(treatment[g], after_switch)
            # No further from the prior than is trusted.
            most = trust * believed + trust_veh
            advantage = believed + min(max(learned[g], -most), most)
            gain[g] = groups.lanes[g] * advantage + groups.lanes[g] * scratch.wave[g]
    if params.age > 0.0:
        owed_veh = gains.movements.work.owed_veh
        for g in range(count):
            owed = 0.0
            for place in range(groups.movement_offset[g], groups.movement_offset[g + 1]):
                owed += owed_veh[groups.movements[place]]
            # Where a phase serves groups in part, movements are told apart.
            part = green_part(gains.treatment[0, g], after_switch)
            gains.gain[g] += vehicle * np.float32(owed) * part


@kernel
def _row(queue_veh: Real, expected_veh: Real, rate_veh: Real) -> Whole:
    """Return the row of a lane: queue, expected arrivals, arrival rate."""
    rate = np.int32(0)
    for edge in RATE_EDGES_VEH:
        rate += rate_veh > edge
    return np.uint16(state_bin(queue_veh, expected_veh) * RATES + rate)


@kernel
def add_up_gains(
    groups: LaneGroups,
    params: FactoredParams,
    short: ShortTerm,
    inputs: Inputs,
    scratch: LaneScratch,
    gains: Gains,
) -> None:
    """Find what all phases gain by what is known and announced now."""
    _weigh(groups, params, short, scratch, gains)
    for phase in range(gains.total.shape[0]):
        _add_up(groups.served_block[:, phase], gains.gain, gains.total[phase])
    if gains.movements.facts.apart.shape[0] > 0:
        _add_up_apart(groups, params, inputs, scratch, gains)
    if inputs.owed_veh.shape[0] > 0:
        _add_owed(groups, params.vehicle, inputs.owed_veh, gains.total)


@kernel
def choose(inputs: Inputs, gains: Gains, phases: IntArray) -> None:
    """Choose for every intersection the phase with the highest sum of gains."""
    highest, total = gains.highest, gains.total
    for i in range(phases.shape[0]):
        phases[i] = 0
        highest[i] = -np.float32(np.inf)
    for phase in range(total.shape[0]):
        number = np.int32(phase)
        for i in range(phases.shape[0]):
            # Of equally good phases the one shown stays, else the first is taken.
            tie = max(TIE, TIE_PART * highest[i])
            gained = total[phase, i] + (tie + tie if inputs.shown[i] == number else ZERO)
            better = gained > highest[i] + tie
            phases[i] = number if better else phases[i]
            highest[i] = gained if better else highest[i]


@kernel
def _add_up(served: Indices, gain: Single, total: Single) -> None:
    """Add up what is gained by a phase of every intersection: (groups served, intersections).

    A phase that an intersection does not have gains what its first place holds: minus infinity.
    """
    for i in range(total.shape[0]):
        total[i] = gain[served[0, i]]
    for k in range(1, served.shape[0]):
        for i in range(total.shape[0]):
            total[i] += gain[served[k, i]]


@kernel
def _add_up_apart(
    groups: LaneGroups, params: FactoredParams, inputs: Inputs, scratch: LaneScratch, gains: Gains
) -> None:
    """Add up what is gained by phases of intersections whose movements are told apart."""
    facts, work, after_switch = gains.movements.facts, gains.movements.work, params.after_switch
    note_vehicles(groups, params.approaching, inputs, scratch, gains.movements)
    for at in range(facts.apart.shape[0]):
        i = facts.apart[at]
        first, before = groups.phase_offset[i], shown_phase(groups, inputs, i)
        for phase in range(first, groups.phase_offset[i + 1]):
            treat(groups, facts, i, phase, before, after_switch, work.vehicles, work)
            total = 0.0
            if params.age > 0.0:
                owed = owed_in_phase(groups, facts, i, phase, before, after_switch, work)
                total += params.vehicle * owed
            stops = groups.all_stop[i] and phase != before
            for place in range(groups.served_offset[phase], groups.served_offset[phase + 1]):
                g = groups.served[place]
                treatment = served_wholly(RED if stops else scratch.shown[g], after_switch)
                if groups.partly[place]:
                    treatment = PARTLY
                part = green_of(treatment, work.served[g], work.green[g], after_switch)
                believed = params.vehicle * (scratch.queue_veh[g] + scratch.expected_veh[g]) * part
                most = params.trust * believed + params.trust_veh
                learned = gains.learned_more[scratch.row[g], treatment]
                gain = believed + min(max(learned, -most), most)
                wave = scratch.wave[g] * (1.0 if treatment == PARTLY else work.served[g])
                total += groups.lanes[g] * (gain + wave)
            gains.total[phase - first, i] = np.float32(total)


@kernel
def green_of(treatment: int, served: float, green: float, after_switch: float) -> float:
    """Return what `green_part` would, for a group whose movements are told apart."""
    if treatment == RED:
        return 0.0
    return 0.5 * after_switch if treatment == PARTLY else served * green


@kernel
def _add_owed(groups: LaneGroups, vehicle: float, owed_veh: FloatArray, total: Single) -> None:
    """Let green count more for those whose shared lanes got stuck."""
    for i in range(total.shape[1]):
        first = groups.phase_offset[i]
        for phase in range(first, groups.phase_offset[i + 1]):
            owed = 0.0
            for place in range(groups.flow_offset[phase], groups.flow_offset[phase + 1]):
                owed += owed_veh[groups.flows[place]]
            total[phase - first, i] += np.float32(vehicle * owed)
