"""Both memories of lanes at once: learned values, and a learned model with a look-ahead."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from dmil.compilation import TypedOnce
from dmil.controllers.lanes.combined_choice import (
    CombinedParams,
    CombinedSpace,
    CombinedTables,
    decide,
)
from dmil.controllers.lanes.factored import FactoredSettings
from dmil.controllers.lanes.factored_gains import ROWS, FactoredParams, make_gains
from dmil.controllers.lanes.lane_groups import LaneGroups
from dmil.controllers.lanes.lane_inputs import STATE_BINS
from dmil.controllers.lanes.lane_memory import LaneMemory, LaneSettings, LaneWork, Waves
from dmil.controllers.lanes.lane_model import OUTCOMES, LookaheadParams
from dmil.controllers.lanes.lookahead import LookaheadSettings
from dmil.controllers.lanes.lookahead_choice import make_plans
from dmil.controllers.lanes.movement_facts import Movements
from dmil.controllers.parameters import parameters_of, with_default

AGE_VEH_PER_S = 0.025
"""What a second of red beyond the usual counts: a quarter of a vehicle in 10 s."""


APART = {"curvature": 0.8, "queue_trust": 0.6, "trust": 1.0}
"""Of the model where movements are told apart, as on most real roads: long queues cost more there,
and what was learned counts sooner, because the formula knows less of them."""


class CombinedSettings(LaneSettings):
    """Both memories of lanes."""

    yields: bool = with_default(LaneSettings, "yields", default=True)
    age: float = with_default(LaneSettings, "age", AGE_VEH_PER_S)
    waves: Waves = with_default(LaneSettings, "waves", "choice")
    outside: bool = with_default(LaneSettings, "outside", default=True)
    recall: bool = with_default(LaneSettings, "recall", default=True)
    censored: bool = with_default(LookaheadSettings, "censored", default=True)
    weight: float = Field(
        default=1.0,
        ge=0,
        allow_inf_nan=False,
        description="Weight of what the model expects two decisions to cost, beside what green is "
        "worth by the values; 0: values alone.",
    )


class CombinedController(LaneMemory):
    """Chooses the phase whose lanes gain most from green, less what the next two decisions cost.

    See docs/controllers/combined.md. Values and the model are learned side by side, in a table
    each.
    """

    name = "combined"
    sources = ("long-term", "prior")
    shapes: ClassVar = {"": (ROWS,), "model_": (STATE_BINS, OUTCOMES)}

    def __init__(self, settings: CombinedSettings | None = None) -> None:
        self.settings = settings or CombinedSettings()
        super().__init__(self.settings)

    def _learned(self) -> CombinedTables:
        return CombinedTables(*self._tables.values())

    def _work(self, groups: LaneGroups, movements: Movements, after_switch: float) -> LaneWork:
        common = {name: getattr(self.settings, name) for name in LaneSettings.model_fields}
        model = common | {"censored": self.settings.censored}
        # Whoever waits for long is counted once, by the values.
        alike, apart = (
            parameters_of(
                LookaheadParams,
                LookaheadSettings(**model | changes),
                age=0.0,
                after_switch=after_switch,
            )
            for changes in ({}, APART)
        )
        values = FactoredSettings(**common)
        params = CombinedParams(
            parameters_of(FactoredParams, values, after_switch=after_switch),
            alike,
            apart,
            self.settings.weight,
        )
        columns = self.table.residual.shape[1]
        gains, plans = (
            make_gains(groups, movements, columns),
            make_plans(groups, movements, columns),
        )
        return LaneWork(TypedOnce(decide), params, CombinedSpace(gains, plans))
