"""The factored memory's decision and what it learns, compiled: all intersections at once."""

from __future__ import annotations

import numpy as np

from dmil.arrays import IntArray
from dmil.compilation import kernel
from dmil.controllers.lanes.factored_gains import (
    FactoredParams,
    Gains,
    add_up_gains,
    choose,
    green_of,
    look_up,
)
from dmil.controllers.lanes.lane_arrivals import count_arrivals, filled_in
from dmil.controllers.lanes.lane_groups import LaneGroups
from dmil.controllers.lanes.lane_inputs import (
    ONE,
    ZERO,
    Inputs,
    LaneScratch,
    ShortTerm,
    aggregate,
    announce,
    expect_announced,
    expect_by_rate,
    find_waves,
    forget_rejected,
    green_part,
    note_shown,
    note_treatment,
)
from dmil.controllers.lanes.movements import (
    look_at_movements,
    remember_treatment,
)
from dmil.memory.residuals import ResidualTable, has_numbers_only, learn_part

NOT_LEARNED_FROM_VEH = np.float32(20.0)
"""Longest queue that is learned from: beyond, the prior's line goes on with the last residual."""


@kernel
def decide(
    groups: LaneGroups,
    params: FactoredParams,
    table: ResidualTable,
    short: ShortTerm,
    inputs: Inputs,
    scratch: LaneScratch,
    gains: Gains,
    phases: IntArray,
) -> bool:
    """Choose all phases and learn from the last choice.

    Every intersection chooses by what it sees and announces that; then, knowing what its neighbours
    mean to do, it chooses for good.

    See `LaneWork` for what it takes and returns; table and short-term memory are changed in place.
    """
    note_shown(groups, inputs, scratch)
    look_up(params.after_switch, table, scratch, gains)
    aggregate(groups, params.approaching, inputs, scratch)
    if not inputs.first:
        forget_rejected(groups, inputs, short)
        count_arrivals(
            groups, params.approaching, params.after_switch, params.rate_step, short, scratch
        )
    look_at_movements(groups, params.age, inputs, scratch, gains.movements)
    expect_by_rate(groups, params.expected, short, scratch)
    for g in range(scratch.wave.shape[0]):
        scratch.wave[g] = ZERO
    add_up_gains(groups, params, short, inputs, scratch, gains)
    choose(inputs, gains, phases)
    if params.expected > 0.0 or params.wave > 0.0:
        announce(groups, params.approaching, inputs, scratch, phases)
        expect_announced(groups, params.expected, short, scratch)
        find_waves(groups, params.vehicle * params.wave, scratch)
        add_up_gains(groups, params, short, inputs, scratch, gains)
        choose(inputs, gains, phases)
    note_treatment(groups, params.after_switch, inputs, scratch, phases)
    learn_values(groups, params, table, short, inputs, scratch, gains, phases)
    return has_numbers_only(table)


@kernel
def learn_values(
    groups: LaneGroups,
    params: FactoredParams,
    table: ResidualTable,
    short: ShortTerm,
    inputs: Inputs,
    scratch: LaneScratch,
    gains: Gains,
    phases: IntArray,
) -> None:
    """Learn from the interval that ended, after `note_treatment`; keep what the next one needs."""
    _prepare_errors(groups, params, inputs, short, scratch, gains, phases)
    _learn(groups, params, table, short, inputs, scratch, gains)
    _remember(short, scratch)


@kernel
def _prepare_errors(
    groups: LaneGroups,
    params: FactoredParams,
    inputs: Inputs,
    short: ShortTerm,
    scratch: LaneScratch,
    gains: Gains,
    phases: IntArray,
) -> None:
    """Find the errors of predictions by the prior alone: minus who waits then counts, and now."""
    vehicle, after_switch = np.float32(params.vehicle), np.float32(params.after_switch)
    discount, error = np.float32(params.discount), gains.error
    for g in range(error.shape[0]):
        left = vehicle * (ONE - green_part(short.treatment[g], after_switch))
        error[g] = left * (short.queue_veh[g] + short.expected_veh[g]) - scratch.waiting_veh[g]
    for g in range(error.shape[0]):
        left = vehicle * (ONE - green_part(scratch.treatment[g], after_switch))
        error[g] -= discount * left * (scratch.queue_veh[g] + scratch.expected_veh[g])
    movements = gains.movements
    facts, memory = movements.facts, movements.memory
    if facts.apart.shape[0] == 0:
        return
    for at in range(facts.apart.shape[0]):
        i = facts.apart[at]
        for g in range(groups.group_offset[i], groups.group_offset[i + 1]):
            treated, served, green = short.treatment[g], memory.served[g], memory.green[g]
            part = green_of(treated, served, green, params.after_switch)
            left = vehicle * np.float32(1.0 - part)
            error[g] = left * (short.queue_veh[g] + short.expected_veh[g]) - scratch.waiting_veh[g]
    remember_treatment(groups, params.after_switch, inputs, movements, phases)
    for at in range(facts.apart.shape[0]):
        i = facts.apart[at]
        for g in range(groups.group_offset[i], groups.group_offset[i + 1]):
            treated, served, green = scratch.treatment[g], memory.served[g], memory.green[g]
            part = green_of(treated, served, green, params.after_switch)
            left = vehicle * np.float32(1.0 - part)
            error[g] -= discount * left * (scratch.queue_veh[g] + scratch.expected_veh[g])


@kernel
def _learn(
    groups: LaneGroups,
    params: FactoredParams,
    table: ResidualTable,
    short: ShortTerm,
    inputs: Inputs,
    scratch: LaneScratch,
    gains: Gains,
) -> None:
    """Learn from the interval that ended; count entries that were known already."""
    known, discount = 0, np.float32(params.discount)
    for i in range(inputs.shown.shape[0]):
        # A rejected request was not executed: nothing is learned of it.
        learns = params.learning and not inputs.first and inputs.shown[i] == inputs.asked[i]
        for g in range(groups.group_offset[i], groups.group_offset[i + 1]):
            row, treatment = scratch.row[g], scratch.treatment[g]
            known += table.times[row, treatment] > 0
            learned_from = short.queue_veh[g] <= NOT_LEARNED_FROM_VEH and not filled_in(short, g)
            if learns and learned_from:
                before, treated = short.row[g], short.treatment[g]
                after = discount * table.residual[row, treatment]
                error = gains.error[g] + after - table.residual[before, treated]
                learn_part(table, before, treated, error)
    scratch.lookups[0] += known
    scratch.lookups[1] += groups.lanes.shape[0] - known


@kernel
def _remember(short: ShortTerm, scratch: LaneScratch) -> None:
    """Keep what the next interval will be judged by."""
    for g in range(short.row.shape[0]):
        short.row[g] = scratch.row[g]
    for g in range(short.row.shape[0]):
        short.treatment[g] = scratch.treatment[g]
    for g in range(short.row.shape[0]):
        short.queue_veh[g] = scratch.queue_veh[g]
    for g in range(short.row.shape[0]):
        short.expected_veh[g] = scratch.expected_veh[g]
