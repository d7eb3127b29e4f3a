"""The decision by both memories of lanes, compiled: all intersections at once."""

from __future__ import annotations

from typing import NamedTuple

from dmil.arrays import IntArray
from dmil.compilation import kernel
from dmil.controllers.lanes.factored_choice import learn_values
from dmil.controllers.lanes.factored_gains import (
    FactoredParams,
    Gains,
    add_up_gains,
    choose,
    look_up,
)
from dmil.controllers.lanes.lane_arrivals import count_arrivals
from dmil.controllers.lanes.lane_groups import LaneGroups
from dmil.controllers.lanes.lane_inputs import (
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
    note_shown,
    note_treatment,
)
from dmil.controllers.lanes.lane_model import LookaheadParams
from dmil.controllers.lanes.lookahead_choice import Plans, add_up_costs
from dmil.controllers.lanes.lookahead_learning import learn_model
from dmil.controllers.lanes.movements import look_at_movements
from dmil.memory.residuals import ResidualTable, has_numbers_only


class CombinedParams(NamedTuple):
    """Numbers for the kernel: those of both memories, and the weight of the model's costs.

    ``model_apart`` has those of the model where movements are told apart.
    """

    values: FactoredParams
    model: LookaheadParams
    model_apart: LookaheadParams
    weight: float


class CombinedTables(NamedTuple):
    """What both have learned: values of lanes, and what the lane model misses."""

    values: ResidualTable
    model: ResidualTable


class CombinedSpace(NamedTuple):
    """Working space of both."""

    gains: Gains
    plans: Plans


@kernel
def decide(
    groups: LaneGroups,
    params: CombinedParams,
    tables: CombinedTables,
    short: ShortTerm,
    inputs: Inputs,
    scratch: LaneScratch,
    space: CombinedSpace,
    phases: IntArray,
) -> bool:
    """Choose all phases and learn from the last choice.

    Every intersection chooses by values alone and announces that; then, knowing what its neighbours
    mean to do, it chooses by both, for good.

    See `LaneWork` for what it takes and returns; tables and short-term memory are changed in place.
    """
    values, model, gains = params.values, params.model, space.gains
    note_shown(groups, inputs, scratch)
    look_up(values.after_switch, tables.values, scratch, gains)
    aggregate(groups, values.approaching, inputs, scratch)
    if not inputs.first:
        forget_rejected(groups, inputs, short)
        count_arrivals(
            groups, values.approaching, values.after_switch, values.rate_step, short, scratch
        )
    look_at_movements(groups, values.age, inputs, scratch, gains.movements)
    expect_by_rate(groups, values.expected, short, scratch)
    for link in range(scratch.green.shape[0]):
        scratch.green[link] = ZERO
    find_waves(groups, values.vehicle * values.wave, scratch)
    add_up_gains(groups, values, short, inputs, scratch, gains)
    choose(inputs, gains, phases)
    announce(groups, values.approaching, inputs, scratch, phases)
    expect_announced(groups, values.expected, short, scratch)
    _weigh_both(groups, params, tables, short, inputs, scratch, space)
    choose(inputs, gains, phases)
    note_treatment(groups, values.after_switch, inputs, scratch, phases)
    learn_model(groups, model, tables.model, short, inputs, scratch, gains.movements)
    learn_values(groups, values, tables.values, short, inputs, scratch, gains, phases)
    return has_numbers_only(tables.values) and has_numbers_only(tables.model)


@kernel
def _weigh_both(
    groups: LaneGroups,
    params: CombinedParams,
    tables: CombinedTables,
    short: ShortTerm,
    inputs: Inputs,
    scratch: LaneScratch,
    space: CombinedSpace,
) -> None:
    """Find what all phases gain, less what they cost."""
    values, model, total = params.values, params.model, space.gains.total
    find_waves(groups, values.vehicle * values.wave, scratch)
    add_up_gains(groups, values, short, inputs, scratch, space.gains)
    if params.weight > 0.0:
        find_waves(groups, model.wave, scratch)
        apart = params.model_apart
        add_up_costs(groups, model, apart, tables.model, short, inputs, scratch, space.plans)
        for phase in range(total.shape[0]):
            for i in range(total.shape[1]):
                total[phase, i] -= params.weight * space.plans.total[phase, i]
