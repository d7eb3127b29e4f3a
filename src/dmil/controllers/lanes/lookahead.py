"""Model memory: a learned model of lanes and a look-ahead of two decisions."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from dmil.compilation import TypedOnce
from dmil.controllers.lanes.lane_groups import LaneGroups
from dmil.controllers.lanes.lane_inputs import STATE_BINS
from dmil.controllers.lanes.lane_memory import LaneMemory, LaneSettings, LaneWork
from dmil.controllers.lanes.lane_model import OUTCOMES, LookaheadParams
from dmil.controllers.lanes.lookahead_choice import decide, make_plans
from dmil.controllers.lanes.movement_facts import Movements
from dmil.controllers.parameters import parameters_of


class LookaheadSettings(LaneSettings):
    """Model memory with look-ahead."""

    depth: Literal[1, 2] = Field(default=2, description="Decisions of lookahead.")
    plan: float = Field(
        default=0.7,
        ge=0,
        le=1,
        description="Weight of the second decision; the rest goes to the queue before it. 1: full "
        "weight, which fails near saturation.",
    )
    terminal: float = Field(
        default=2.0,
        ge=0,
        allow_inf_nan=False,
        description="Cost of a vehicle left in the queue, in mean vehicles waiting.",
    )
    curvature: float = Field(
        default=0.2,
        ge=0,
        allow_inf_nan=False,
        description="Cost of the square of a lane's remaining queue: long queues cost more.",
    )
    discount: float = Field(default=0.9, ge=0, le=1, description="γ.")
    later: float = Field(
        default=0.5,
        ge=0,
        le=1,
        description="Weight of a vehicle expected in the next interval, by its lane's arrival "
        "rate.",
    )
    rounds: int = Field(
        default=3, ge=0, le=10, description="Rounds of announcements among neighbours; 0: none."
    )
    wave: float = Field(
        default=1.0,
        ge=0,
        allow_inf_nan=False,
        description="Gain of green if departing vehicles find green ahead by the announcement of "
        "the next intersection, in mean vehicles waiting.",
    )
    trust: float = Field(
        default=5.0,
        ge=0,
        allow_inf_nan=False,
        description="Number of updates after which an entry counts half.",
    )
    queue_trust: float = Field(
        default=0.3,
        ge=0,
        le=1,
        description="Fraction of the learned next queue that is used; learned costs are used "
        "fully.",
    )
    censored: bool = Field(
        default=False,
        description="Whether vehicles that still move are taken as neither queued nor gone when "
        "the model learns.",
    )


class LookaheadController(LaneMemory):
    """Chooses the first of the two phases that cost least together.

    See docs/controllers/lookahead.md. Its memory is one table at the central unit, of what a simple
    lane model misses, which every intersection writes at every decision; and each lane's arrival
    rate.
    """

    name = "lookahead"
    sources = ("learned", "lane model")
    shapes: ClassVar = {"": (STATE_BINS, OUTCOMES)}

    def __init__(self, settings: LookaheadSettings | None = None) -> None:
        self.settings = settings or LookaheadSettings()
        super().__init__(self.settings)

    def _work(self, groups: LaneGroups, movements: Movements, after_switch: float) -> LaneWork:
        columns = self.table.residual.shape[1]
        params = parameters_of(
            LookaheadParams,
            self.settings,
            plan=self.settings.plan if self.settings.depth == 2 else 0.0,
            after_switch=after_switch,
        )
        return LaneWork(TypedOnce(decide), params, make_plans(groups, movements, columns))
