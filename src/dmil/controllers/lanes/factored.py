"""Factored dual memory: values of lanes add up, one small table serves every lane."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from dmil.compilation import TypedOnce
from dmil.controllers.lanes.factored_choice import decide
from dmil.controllers.lanes.factored_gains import ROWS, FactoredParams, make_gains
from dmil.controllers.lanes.lane_groups import LaneGroups
from dmil.controllers.lanes.lane_memory import LaneMemory, LaneSettings, LaneWork
from dmil.controllers.lanes.movement_facts import Movements
from dmil.controllers.parameters import parameters_of


class FactoredSettings(LaneSettings):
    """Factored dual memory."""

    rates: bool = Field(
        default=True,
        description="Whether rows distinguish lanes by arrival rate; otherwise rows have no "
        "short-term memory.",
    )
    wave: float = Field(
        default=0.7,
        ge=0,
        allow_inf_nan=False,
        description="Value of green, in vehicles, if departing vehicles find green ahead by the "
        "announcement of the next intersection; 0: no coordination.",
    )
    discount: float = Field(default=0.9, ge=0, lt=1, description="γ.")
    vehicle: float = Field(
        default=2.0,
        gt=0,
        allow_inf_nan=False,
        description="Value of a waiting vehicle in the prior, in mean vehicles waiting.",
    )
    trust: float = Field(
        default=0.05,
        ge=0,
        allow_inf_nan=False,
        description="ρ: trust region, how far learning may shift an advantage A0 of the prior: "
        "ρ·A0 + trust_veh.",
    )
    trust_veh: float = Field(default=1.0, ge=0, allow_inf_nan=False, description="See trust.")


class FactoredController(LaneMemory):
    """Chooses the phase whose lanes gain most from green; see docs/controllers/factored.md.

    Its long-term memory is one table of lanes at the central unit, which every intersection writes
    at every decision; its short-term memory is each lane's arrival rate and what was done last.
    """

    name = "factored"
    sources = ("long-term", "prior")
    shapes: ClassVar = {"": (ROWS,)}

    def __init__(self, settings: FactoredSettings | None = None) -> None:
        self.settings = settings or FactoredSettings()
        super().__init__(self.settings)

    def _work(self, groups: LaneGroups, movements: Movements, after_switch: float) -> LaneWork:
        return LaneWork(
            TypedOnce(decide),
            parameters_of(FactoredParams, self.settings, after_switch=after_switch),
            make_gains(groups, movements, self.table.residual.shape[1]),
        )
