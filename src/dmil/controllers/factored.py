"""Factored dual memory: values of lanes add up, one small table serves every lane."""

from __future__ import annotations

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from dmil.controllers.factored_choice import decide
from dmil.controllers.factored_state import (
    KEPT,
    PARTLY,
    ROWS,
    SWITCHED,
    Scratch,
    Seen,
    ShortTerm,
    Weights,
)
from dmil.controllers.lane_groups import lane_groups
from dmil.controllers.protocol import Arrays, FloatArray, IntArray, MemoryUse, Situation
from dmil.errors import DivergedError, PolicyError
from dmil.memory.factored import FactoredTable, make_factored_table, restored_table
from dmil.simulation import Observation

SOURCES = ("long-term", "prior")


class FactoredSettings(BaseModel):
    """Factored dual memory."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    approaching: bool = Field(
        default=True, description="Whether vehicles that arrive within the interval are seen."
    )
    rates: bool = Field(
        default=True,
        description="Whether rows tell lanes of different arrival rates apart; without, there is "
        "no short-term memory in a row.",
    )
    expected: float = Field(
        default=0.3,
        ge=0,
        le=1,
        description="Weight of a vehicle that is not seen yet and expected within the interval, by "
        "the announcement of the intersection before or by the arrival rate; 0: none.",
    )
    wave: float = Field(
        default=0.7,
        ge=0,
        allow_inf_nan=False,
        description="Vehicles that green for a lane counts more if those who leave it find green "
        "ahead, by the announcement of the next intersection; 0: no coordination.",
    )
    learning: bool = Field(default=True, description="Whether the table changes.")
    discount: float = Field(default=0.9, ge=0, lt=1, description="γ.")
    vehicle: float = Field(
        default=2.0,
        gt=0,
        allow_inf_nan=False,
        description="What a vehicle that waits is worth by the prior, in mean vehicles waiting.",
    )
    trust: float = Field(
        default=0.05,
        ge=0,
        allow_inf_nan=False,
        description="ρ: how far what was learned may move an advantage A0 of the prior: ρ·A0 + "
        "trust_veh.",
    )
    trust_veh: float = Field(default=1.0, ge=0, allow_inf_nan=False, description="See trust.")
    evidence: float = Field(
        default=0.0,
        ge=0,
        allow_inf_nan=False,
        description="Standard errors that are taken off what was learned; 0: none.",
    )
    rate_step: float = Field(
        default=0.02, gt=0, le=1, description="β: step of the moving average of arrivals."
    )


class FactoredController:
    """Chooses the phase whose lanes gain most from green; see docs/controllers/factored.md.

    Its long-term memory is one table of lanes at the central unit, which every intersection writes
    at every decision; its short-term memory is each lane's arrival rate and what was done last. It
    learns from the vehicles that wait in each lane, not from the reward of the run.

    Parameters
    ----------
    settings
        See `FactoredSettings`.
    """

    def __init__(self, settings: FactoredSettings | None = None) -> None:
        self.settings = settings or FactoredSettings()
        self._table: FactoredTable | None = None
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
        self._weights = Weights(
            vehicle=settings.vehicle,
            expected=settings.expected,
            wave=settings.wave,
            after_switch=max(0.0, 1.0 - lost_s / timing.decision_interval_s),
            discount=settings.discount,
            trust=settings.trust,
            trust_veh=settings.trust_veh,
            evidence=settings.evidence,
            rate_step=settings.rate_step,
            use_approaching=settings.approaching,
            use_rates=settings.rates,
            learns=settings.learning,
        )
        count, links = groups.lanes.size, groups.unseen.size
        self._short = ShortTerm(
            rate_veh=np.full(count, 0.5, np.float32),
            rated=np.zeros(count, np.float32),
            queue_veh=np.zeros(count, np.float32),
            expected_veh=np.zeros(count, np.float32),
            row=np.zeros(count, np.int16),
            treatment=np.zeros(count, np.int8),
        )
        self._asked: IntArray | None = None
        columns = 1 + (PARTLY if groups.partly.any() else SWITCHED if lost_s else KEPT)
        if self._table is None:
            with_errors = settings.evidence > 0.0
            self._table = make_factored_table(ROWS, columns, with_errors=with_errors)
        elif self._table.residual.shape[1] < columns:
            raise PolicyError(
                f"it knows {self._table.residual.shape[1]} of {columns} ways to treat a lane",
                where=f"factored memory on network '{situation.network.name}'",
                expected="a memory that has learned where signals lose time as here",
                mend="train it on this network, with its signal timing",
            )
        self._scratch = Scratch(
            queue_veh=np.zeros(count, np.float32),
            expected_veh=np.zeros(count, np.float32),
            waiting_veh=np.zeros(count, np.float32),
            row=np.zeros(count, np.int16),
            shown=np.zeros(count, np.int8),
            treatment=np.zeros(count, np.int8),
            gain=np.zeros(count, np.float32),
            wave=np.zeros(count, np.float32),
            link_rate_veh=np.zeros(links, np.float32),
            inflow_veh=np.zeros(links, np.float32),
            green=np.zeros(links, np.float32),
            sure=np.zeros_like(self._table.residual),
            lookups=self._lookups,
        )

    @property
    def table(self) -> FactoredTable:
        """The long-term memory."""
        assert self._table is not None, "begin comes before anything else"
        return self._table

    def decide(self, observation: Observation, reward: FloatArray | None) -> IntArray:
        """Choose all phases, neighbours announcing theirs, and learn from the last choice.

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
        decide(self._groups, self._weights, self.table, self._short, seen, self._scratch, phases)
        if not np.isfinite(self.table.residual).all():
            raise DivergedError("factored", "values of lanes", observation.time_s)
        self._asked = phases
        return phases.copy()

    def lookups(self) -> dict[str, int]:
        """Return how often a lane's entry had been learned, and how often the prior stood in."""
        return dict(zip(SOURCES, self._lookups.tolist(), strict=True))

    def memory_use(self) -> MemoryUse:
        """Return how much is remembered now; an entry is one number with its count."""
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
        self._table = restored_table(arrays, self.table)
        self._scratch = self._scratch._replace(sure=np.zeros_like(self._table.residual))
