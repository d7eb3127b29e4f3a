"""What memories of lanes share: they learn online, neighbours announce, one table serves all."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np
import numpy.typing as npt
from pydantic import Field

from dmil.arrays import Arrays, FloatArray, IntArray
from dmil.compilation import TypedOnce
from dmil.controllers.lanes.lane_groups import LaneGroups, lane_groups
from dmil.controllers.lanes.lane_inputs import (
    KEPT,
    PARTLY,
    SWITCHED,
    Inputs,
    LaneScratch,
    ShortTerm,
)
from dmil.controllers.lanes.movement_facts import Movements, bytes_remembered, movements_of
from dmil.controllers.parameters import Settings
from dmil.controllers.protocol import MemoryUse, RunContext
from dmil.controllers.rules.shared_lanes import SharedLaneGuard
from dmil.errors import DivergedError, PolicyError
from dmil.memory.residuals import ResidualTable, make_residuals, restored_residuals
from dmil.scenarios import lost_s
from dmil.simulation import Observation

Waves = Literal["everywhere", "choice"]
FIRST_RATE_VEH = 0.5
"""Arrivals per interval and lane before any were counted."""
NOTHING_OWED = np.zeros(0)


class LaneSettings(Settings):
    """What memories of lanes have in common."""

    approaching: bool = Field(
        default=True, description="Whether vehicles that arrive within the interval are observed."
    )
    expected: float = Field(
        default=0.3,
        ge=0,
        le=1,
        description="Weight of an unseen vehicle expected within the interval, by the "
        "announcement of the upstream intersection or the arrival rate; 0: none.",
    )
    yields: bool = Field(
        default=False,
        description="Whether green counts less for turns that must yield to others with green.",
    )
    age: float = Field(
        default=0.0,
        ge=0,
        allow_inf_nan=False,
        description="What a second of red beyond the usual counts, in vehicles; 0: nothing.",
    )
    waves: Waves = Field(
        default="everywhere",
        description="Where green ahead counts: everywhere, or only where the next intersection "
        "has a choice of phases.",
    )
    outside: bool = Field(
        default=False,
        description="Whether those count who wait unseen behind a full entry of the network, as "
        "far as the balance of flows tells.",
    )
    recall: bool = Field(
        default=False,
        description="Whether a detector that falls silent for too long is taken for dead, and what "
        "it would count is filled in from memory.",
    )
    guard: bool = Field(
        default=True,
        description="Whether red counts more, the longer it lasts, where shared lanes were "
        "blocked.",
    )
    learning: bool = Field(default=True, description="Whether it learns.")
    rate_step: float = Field(
        default=0.02, gt=0, le=1, description="β: step of the moving average of arrival rates."
    )


class LaneWork(NamedTuple):
    """What decides for a memory of lanes in a run.

    Attributes
    ----------
    kernel
        Takes lane groups, numbers, table, short-term memory, inputs, scratch, its own working space
        and phases to fill in, (intersections,) int32; tells whether all that was learned is finite.
    params
        The numbers.
    space
        The working space.
    """

    kernel: TypedOnce
    params: tuple[Any, ...]
    space: tuple[Any, ...]


class LaneMemory(ABC):
    """One table of lanes at the central unit, and what each intersection saw and did last (ours).

    It learns from the vehicles that wait in each lane, not from the reward of the run.
    """

    name: ClassVar[str]
    sources: ClassVar[tuple[str, str]]
    """Where an entry came from: it had been learned, or it had not."""

    shapes: ClassVar[Mapping[str, tuple[int, ...]]]
    """Rows of every table, and outcomes where an entry is not a single number; by the prefix that
    its arrays have where they are saved."""

    def __init__(self, settings: LaneSettings) -> None:
        self._tables: dict[str, ResidualTable] = {}
        self._lookups = np.zeros(len(self.sources), np.int64)
        self._lanes = settings

    def reset(self, context: RunContext) -> None:
        """Forget the arrivals of the last run; the table stays, on whatever network.

        Raises
        ------
        PolicyError
            If lanes are treated in ways here that the table does not know.
        """
        own = self._lanes
        self._groups = groups = lane_groups(
            context, waves_everywhere=own.waves == "everywhere", outside=own.outside
        )
        self._short = _short_term(groups, recall=own.recall)
        self._scratch = _scratch(groups, self._lookups)
        self._guard = SharedLaneGuard(context, enabled=own.guard)
        self._asked: IntArray | None = None
        lost = lost_s(context.timing, context.network)
        columns = 1 + (PARTLY if groups.partly.any() else SWITCHED if lost.any() else KEPT)
        if not self._tables:
            self._tables = {
                prefix: make_residuals(rows, columns, *outcomes)
                for prefix, (rows, *outcomes) in self.shapes.items()
            }
        known = min(table.residual.shape[1] for table in self._tables.values())
        if known < columns:
            raise PolicyError(
                f"it knows {known} of {columns} ways to treat a lane",
                where=f"memory of '{self.name}' on network '{context.network.name}'",
                expected="a memory that has learned where signals lose time as here",
                mend="train it on this network, with its signal timing",
            )
        # One table serves all intersections: what a change costs there is taken in the mean.
        after_switch = max(0.0, 1.0 - float(lost.mean()) / context.decision_interval_s)
        self._movements = movements_of(context, groups, yields=own.yields, age=own.age > 0)
        self._decides = self._work(groups, self._movements, after_switch)

    @property
    def table(self) -> ResidualTable:
        """The long-term memory; the first of its tables."""
        assert self._tables, "reset comes before anything else"
        return next(iter(self._tables.values()))

    def _learned(self) -> Any:
        """Return what the kernel takes as the table."""
        return self.table

    def decide(self, observation: Observation, reward: FloatArray | None) -> IntArray:
        """Choose all phases, neighbours announcing theirs, and learn from the last choice.

        Raises
        ------
        DivergedError
            If what was learned is not a number.
        """
        phases = np.empty(observation.phase.size, np.int32)
        guard = self._guard
        # As the compiled kernel reads them, whatever the simulator's arrays are.
        shown = np.ascontiguousarray(observation.phase, np.int32)
        inputs = Inputs(
            queue_veh=np.ascontiguousarray(observation.queue_veh, np.int32).ravel(),
            approaching_veh=np.ascontiguousarray(observation.approaching_veh, np.int32).ravel(),
            waiting_veh=np.ascontiguousarray(observation.waiting_veh, np.float64).ravel(),
            owed_veh=guard.owed_veh(observation).ravel() if guard.needed else NOTHING_OWED,
            shown=shown,
            asked=shown if self._asked is None else self._asked,
            first=self._asked is None,
        )
        kernel, params, space = self._decides
        numbers_only = kernel(
            self._groups,
            params,
            self._learned(),
            self._short,
            inputs,
            self._scratch,
            space,
            phases,
        )
        if not numbers_only:
            raise DivergedError(self.name, "residuals of lanes", observation.time_s)
        self._asked = phases
        return phases.copy()

    def lookups(self) -> dict[str, int]:
        """Return how often a lane's entry had been learned, and how often it had not."""
        return dict(zip(self.sources, self._lookups.tolist(), strict=True))

    def memory_use(self) -> MemoryUse:
        """Return how much is remembered now; what is learned of a row and column is one entry."""
        agents = self._groups.group_offset.size - 1
        short = sum(array.nbytes for array in self._short) + self._guard.bytes_total
        short += bytes_remembered(self._movements, age=self._lanes.age > 0)
        entries = sum(table.entries for table in self._tables.values())
        return MemoryUse(
            short_term_entries=self._groups.lanes.size / agents,
            long_term_entries=float(entries),
            msize=float(entries),
            entries_total=entries + self._groups.lanes.size,
            bytes_total=sum(table.bytes_total for table in self._tables.values()) + short,
        )

    def arrays(self) -> Arrays:
        """Return the tables."""
        return {
            prefix + name: array.copy()
            for prefix, table in self._tables.items()
            for name, array in table._asdict().items()
        }

    def restore(self, arrays: Arrays) -> None:
        """Replace the tables.

        Raises
        ------
        PolicyError
            If the arrays are not those of such tables.
        """
        self._tables = {
            prefix: restored_residuals(arrays, table, prefix)
            for prefix, table in self._tables.items()
        }

    @abstractmethod
    def _work(self, groups: LaneGroups, movements: Movements, after_switch: float) -> LaneWork:
        """Return what decides in a run.

        Parameters
        ----------
        groups, movements
            Of the network.
        after_switch
            Part of an interval that is left to a lane whose green begins with it.
        """


def _short_term(groups: LaneGroups, *, recall: bool) -> ShortTerm:
    count = groups.lanes.size
    heard = count if recall else 0
    return ShortTerm(
        rate_veh=np.full(count, FIRST_RATE_VEH, np.float32),
        rated=np.zeros(count, np.uint16),
        queue_veh=np.zeros(count, np.float32),
        expected_veh=np.zeros(count, np.float32),
        row=np.zeros(count, np.uint16),
        treatment=np.zeros(count, np.uint8),
        outside_veh=np.zeros(groups.entries.size, np.float32),
        silent=np.zeros(heard, np.uint8),
        longest=np.zeros(heard, np.uint8),
        red_rate=np.zeros(heard, np.uint16),
    )


def _scratch(groups: LaneGroups, lookups: npt.NDArray[np.int64]) -> LaneScratch:
    count, links = groups.lanes.size, groups.unseen.size
    return LaneScratch(
        queue_veh=np.zeros(count, np.float32),
        expected_veh=np.zeros(count, np.float32),
        waiting_veh=np.zeros(count, np.float32),
        moving_veh=np.zeros(count, np.float32),
        joined_veh=np.zeros(count, np.float32),
        tells=np.zeros(count, np.uint8),
        row=np.zeros(count, np.uint16),
        shown=np.zeros(count, np.uint8),
        treatment=np.zeros(count, np.uint8),
        wave=np.zeros(count, np.float32),
        link_rate_veh=np.zeros(links, np.float32),
        inflow_veh=np.zeros(links, np.float32),
        green=np.zeros(links, np.float32),
        per_rate=np.zeros(links, np.float32),
        lookups=lookups,
    )
