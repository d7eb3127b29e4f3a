"""Model memory: a learned model of lanes and a look-ahead of two decisions."""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from dmil.controllers.factored_state import (
    ARRIVALS,
    KEPT,
    PARTLY,
    QUEUES,
    SWITCHED,
    Scratch,
    Seen,
    ShortTerm,
)
from dmil.controllers.lane_groups import lane_groups
from dmil.controllers.lookahead_choice import OUTCOMES, Outlook, Plans, decide
from dmil.controllers.protocol import Arrays, FloatArray, IntArray, MemoryUse, Situation
from dmil.errors import DivergedError, PolicyError
from dmil.memory.outcomes import OutcomeTable, make_outcome_table, restored_outcomes
from dmil.simulation import Observation

SOURCES = ("learned", "lane model")


class LookaheadSettings(BaseModel):
    """Model memory with look-ahead."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    depth: Literal[1, 2] = Field(default=2, description="How many decisions it looks ahead.")
    plan: float = Field(
        default=0.7,
        ge=0,
        le=1,
        description="How far the second decision is counted on; the rest of its weight has what is "
        "queued before it. 1: entirely, which fails near saturation.",
    )
    terminal: float = Field(
        default=2.0,
        ge=0,
        allow_inf_nan=False,
        description="Cost of a vehicle that is left queued, in mean vehicles waiting.",
    )
    curvature: float = Field(
        default=0.2,
        ge=0,
        allow_inf_nan=False,
        description="Cost of the square of a lane's queue that is left: long queues cost more.",
    )
    discount: float = Field(default=0.9, ge=0, le=1, description="γ.")
    approaching: bool = Field(
        default=True, description="Whether vehicles that arrive within the interval are seen."
    )
    expected: float = Field(
        default=0.3,
        ge=0,
        le=1,
        description="Weight of a vehicle that is not seen yet and expected within the interval, by "
        "the announcement of the intersection before or by the arrival rate; 0: none.",
    )
    later: float = Field(
        default=0.5,
        ge=0,
        le=1,
        description="Weight of a vehicle that is expected in the interval after, by its lane's "
        "arrival rate.",
    )
    rounds: int = Field(
        default=3, ge=0, le=10, description="How often neighbours announce; 0: never."
    )
    wave: float = Field(
        default=1.0,
        ge=0,
        allow_inf_nan=False,
        description="What green for a lane gains if those who leave it find green ahead, by the "
        "announcement of the next intersection, in mean vehicles waiting.",
    )
    learning: bool = Field(default=True, description="Whether the table changes.")
    trust: float = Field(
        default=5.0,
        ge=0,
        allow_inf_nan=False,
        description="After how many times half of what an entry learned is believed.",
    )
    queue_trust: float = Field(
        default=0.3,
        ge=0,
        le=1,
        description="Part of what was learned of queues' ends that is used; what was learned of "
        "their cost always is.",
    )
    rate_step: float = Field(
        default=0.02, gt=0, le=1, description="β: step of the moving average of arrivals."
    )


class LookaheadController:
    """Chooses the first of the two phases that cost least together.

    See docs/controllers/lookahead.md. Its memory is one table at the central unit, of what a simple
    lane model misses, which every intersection writes at every decision; and each lane's arrival
    rate. It learns from what is seen of lanes, not from the reward of the run.

    Parameters
    ----------
    settings
        See `LookaheadSettings`.
    """

    def __init__(self, settings: LookaheadSettings | None = None) -> None:
        self.settings = settings or LookaheadSettings()
        self._table: OutcomeTable | None = None
        self._lookups = np.zeros(len(SOURCES), np.int64)

    def begin(self, situation: Situation) -> None:
        """Forget the arrivals of the last run; the table stays, on whatever network.

        Raises
        ------
        PolicyError
            If lanes are treated in ways here that the table does not know.
        """
        settings, timing = self.settings, situation.timing
        self._groups = groups = lane_groups(situation)
        lost_s = timing.clearance_s + timing.startup_lost_s
        self._outlook = Outlook(
            discount=settings.discount,
            terminal=settings.terminal,
            curvature=settings.curvature,
            plan=settings.plan if settings.depth == 2 else 0.0,
            rounds=settings.rounds,
            expected=settings.expected,
            later=settings.later,
            wave=settings.wave,
            trust=settings.trust,
            queue_trust=settings.queue_trust,
            rate_step=settings.rate_step,
            after_switch=max(0.0, 1.0 - lost_s / timing.decision_interval_s),
            use_approaching=settings.approaching,
            learns=settings.learning,
        )
        count, links = groups.lanes.size, groups.unseen.size
        in_part = bool(groups.partly.any())
        effects = 3 if in_part else 2
        self._short = ShortTerm(
            rate_veh=np.full(count, 0.5, np.float32),
            rated=np.zeros(count, np.float32),
            queue_veh=np.zeros(count, np.float32),
            expected_veh=np.zeros(count, np.float32),
            row=np.zeros(count, np.int16),
            treatment=np.zeros(count, np.int8),
        )
        self._scratch = Scratch(
            queue_veh=np.zeros(count, np.float32),
            expected_veh=np.zeros(count, np.float32),
            waiting_veh=np.zeros(count, np.float32),
            row=np.zeros(0, np.int16),
            shown=np.zeros(count, np.int8),
            treatment=np.zeros(count, np.int8),
            gain=np.zeros(0, np.float32),
            wave=np.zeros(count, np.float32),
            link_rate_veh=np.zeros(links, np.float32),
            inflow_veh=np.zeros(links, np.float32),
            green=np.zeros(links, np.float32),
            sure=np.zeros((0, 0), np.float32),
            lookups=self._lookups,
        )
        self._plans = Plans(
            cost=np.zeros((count, effects, effects)),
            effect=np.zeros(count, np.int8),
            known_veh=np.zeros(count, np.float32),
        )
        self._asked: IntArray | None = None
        columns = 1 + (PARTLY if in_part else SWITCHED if lost_s else KEPT)
        if self._table is None:
            self._table = make_outcome_table(QUEUES * ARRIVALS, columns, OUTCOMES)
        elif self._table.times.shape[1] < columns:
            raise PolicyError(
                f"it knows {self._table.times.shape[1]} of {columns} ways to treat a lane",
                where=f"model memory on network '{situation.network.name}'",
                expected="a memory that has learned where signals lose time as here",
                mend="train it on this network, with its signal timing",
            )

    @property
    def table(self) -> OutcomeTable:
        """What was learned."""
        assert self._table is not None, "begin comes before anything else"
        return self._table

    def decide(self, observation: Observation, reward: FloatArray | None) -> IntArray:
        """Choose all phases, neighbours announcing theirs, and learn from the last interval.

        Raises
        ------
        DivergedError
            If what was learned is not a number.
        """
        phases = np.empty(observation.phase.size, np.int32)
        seen = Seen(
            queue_veh=observation.queue_veh.ravel(),
            approaching_veh=observation.approaching_veh.ravel(),
            waiting_veh=observation.waiting_veh.ravel(),
            shown=observation.phase,
            asked=observation.phase if self._asked is None else self._asked,
            first=self._asked is None,
        )
        decide(
            self._groups,
            self._outlook,
            self.table,
            self._short,
            seen,
            self._scratch,
            self._plans,
            phases,
        )
        if not np.isfinite(self.table.residual).all():
            raise DivergedError("lookahead", "residuals of lanes", observation.time_s)
        self._asked = phases
        return phases.copy()

    def lookups(self) -> dict[str, int]:
        """Return how often a lane's entry had been learned, and how often only the model spoke."""
        return dict(zip(SOURCES, self._lookups.tolist(), strict=True))

    def memory_use(self) -> MemoryUse:
        """Return how much is remembered now; an entry is what two numbers miss, with its count."""
        agents = self._groups.group_offset.size - 1
        short = sum(array.nbytes for array in self._short)
        entries = self.table.entries
        return MemoryUse(
            short_term_entries=self._groups.lanes.size / agents,
            long_term_entries=float(entries),
            table_entries=0.0,
            msize=float(entries),
            entries_total=entries + self._groups.lanes.size,
            bytes_total=self.table.bytes_total + short,
        )

    def arrays(self) -> Arrays:
        """Return the table."""
        return {name: array.copy() for name, array in self.table._asdict().items()}

    def restore(self, arrays: Arrays) -> None:
        """Replace the table.

        Raises
        ------
        PolicyError
            If the arrays are not those of such a table.
        """
        self._table = restored_outcomes(arrays, self.table)
