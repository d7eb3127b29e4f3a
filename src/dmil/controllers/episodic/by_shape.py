"""What learners share whose memory belongs to all intersections of one shape.

Their states are the vehicles queued on the movements that need a signal: the others are always
served, so no choice depends on them.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt
from pydantic import Field

from dmil.arrays import Arrays, FloatArray, IntArray
from dmil.compilation import kernel
from dmil.controllers.parameters import GUARD, Settings
from dmil.controllers.protocol import MemoryUse, RunContext
from dmil.controllers.rules.shared_lanes import SharedLaneGuard
from dmil.controllers.tabular.agents import Agents, agents_of
from dmil.controllers.tabular.choice import DRAWS, explores, greedy_action, uniform_action
from dmil.errors import DivergedError, PolicyError
from dmil.memory.neighbours import KeyArray
from dmil.memory.saved import saved_array
from dmil.network import RoadNetwork
from dmil.simulation import Observation

DECISIONS = "decisions"
Chosen = tuple[npt.NDArray[Any], ...]
LARGEST_VEH = 4095
"""Counts above are taken for this: squares of sums up to it are whole in 32-bit floats."""


class SharedSettings(Settings):
    """What all of these learners are told."""

    approaching: bool = Field(
        default=False, description="Whether the state includes approaching vehicles."
    )
    training_decisions: int = Field(
        default=3600,
        ge=1,
        description="Planned decisions of training, for the schedules: by default 10 episodes of "
        "an hour, decisions every 10 s.",
    )
    epsilon_first: float = Field(
        default=1.0, ge=0, le=1, description="ε at the first decision of training."
    )
    epsilon_last: float = Field(default=0.05, ge=0, le=1, description="Final ε.")
    exploration_part: float = Field(
        default=0.2, gt=0, le=1, description="Fraction of training in which ε falls linearly."
    )
    guard: bool = Field(default=True, description=GUARD)
    learning: bool = Field(
        default=True,
        description="Whether it explores and learns; off for a frozen, greedy evaluation.",
    )


class SharedLearner(ABC):
    """One agent per intersection; agents of one shape have one memory, which is its subclass's.

    Parameters
    ----------
    name
        Name of the controller, for errors.
    settings
        What all of them share.
    """

    SOURCES: ClassVar[tuple[str, ...]] = ()
    """Where what is looked up may be found: names of what kernels count."""

    def __init__(self, name: str, settings: SharedSettings) -> None:
        self._name = name
        self._lookups = np.zeros(len(self.SOURCES), np.int64)
        self._shared_settings = settings
        self._agents: Agents | None = None
        # Decisions that were learned from, over all runs.
        self._decisions = 0

    def reset(self, context: RunContext) -> None:
        """Get ready for a run; what was learned in an earlier run on the same shapes stays.

        Raises
        ------
        PolicyError
            If this controller learned on intersections of other shapes.
        """
        network = context.network
        agents, before = agents_of(network), self._agents
        if before is not None and before.signatures != agents.signatures:
            raise PolicyError(
                "it learned on intersections of other shapes",
                where=f"controller on network '{network.name}'",
                expected="the network that it learned on, or one of the same shapes in its order",
                mend="make a new controller for another network",
            )
        self._agents = agents
        self._situation, self._rng = context, context.rng
        self._columns, self._there = signalled_columns(network)
        self._guard = SharedLaneGuard(context, enabled=self._shared_settings.guard)
        self._phase_count = np.array([len(i.phases) for i in network.intersections], np.int32)
        if before is None:
            self._start()

    @property
    def agents(self) -> Agents:
        """The agents that this controller controls."""
        assert self._agents is not None, "reset comes before anything else"
        return self._agents

    @property
    def epsilon(self) -> float:
        """Chance of a random action now: it falls linearly, and is 0 for who does not learn."""
        settings = self._shared_settings
        if not settings.learning:
            return 0.0
        falls = settings.exploration_part * settings.training_decisions
        left = max(0.0, 1.0 - self._decisions / falls)
        return settings.epsilon_last + left * (settings.epsilon_first - settings.epsilon_last)

    @property
    def places(self) -> int:
        """Numbers in a state."""
        return int(self._columns.shape[1]) * (2 if self._shared_settings.approaching else 1)

    def states(self, observation: Observation) -> IntArray:
        """Return the states of all agents: (agents, places) int32."""
        queue = self.signalled(observation.queue_veh)
        if not self._shared_settings.approaching:
            return queue
        return np.hstack([queue, self.signalled(observation.approaching_veh)])

    def signalled(self, counts: IntArray) -> IntArray:
        """Take the columns of movements that need a signal, and 0 where there are fewer."""
        found: IntArray = np.take_along_axis(counts, self._columns, axis=1) * self._there
        return np.minimum(found, np.int32(LARGEST_VEH))

    def choose(self, value: FloatArray, observation: Observation) -> IntArray:
        """Choose ε-greedily, of equally good actions one at random; the guard may overrule it.

        Parameters
        ----------
        value: (agents, actions) float64
            Infinite where an action was never tried.
        observation
            What is seen now.

        Returns
        -------
        action: (agents,) int32

        Raises
        ------
        DivergedError
            If a value is not a number.
        """
        if np.isnan(value).any():
            raise DivergedError(self._name, "values of the phases", observation.time_s)
        action = np.zeros(value.shape[0], np.int32)
        draws = self._rng.random((value.shape[0], DRAWS))
        alike = np.arange(value.shape[1], dtype=np.int32)
        choose_all(value, self._phase_count, alike, draws, self.epsilon, action)
        self._guard.overrule(observation, action)
        return action

    def lookups(self) -> dict[str, int]:
        """Return how often was looked up so far, by where a value was found."""
        return dict(zip(self.SOURCES, self._lookups.tolist(), strict=True))

    def use_of(self, entries: IntArray, bytes_total: int) -> MemoryUse:
        """Return the memory in use.

        Parameters
        ----------
        entries: (shapes,) int
            Entries of each shape's memory.
        bytes_total: int
            Their memory, in bytes.
        """
        mean = float(entries[self.agents.shape].mean())
        return MemoryUse(
            0.0, 0.0, mean, mean, int(entries.sum()), bytes_total + self._guard.bytes_total
        )

    def _with_decisions(self, arrays: Arrays) -> Arrays:
        return {**arrays, DECISIONS: np.array([self._decisions], np.int64)}

    def _take_decisions(self, arrays: Arrays) -> None:
        """Go on counting decisions from a saved number: PolicyError if there is none."""
        self._decisions = int(saved_array(arrays, DECISIONS, (1,), np.int64, least=0)[0])

    @abstractmethod
    def _start(self) -> None:
        """Make the memories to start from."""


class ReturnWindow:
    """The last n choices of a run, until their returns are known (Sutton & Barto, §7.1).

    The horizon cuts a task that goes on: the last choices of a run have no return and are not
    remembered.

    Parameters
    ----------
    steps
        n.
    discount
        γ.
    """

    def __init__(self, steps: int, discount: float) -> None:
        self._steps = steps
        self._discounts = (discount ** np.arange(steps + 1, dtype=np.float64)).tolist()
        self._chosen: list[Chosen] = []
        self._rewards: list[FloatArray] = []

    def choose(self, *chosen: npt.NDArray[Any]) -> None:
        """Note a choice.

        Parameters
        ----------
        chosen: (agents, …) arrays
            What to know of it later, such as states and actions; not changed afterwards.
        """
        self._chosen.append(chosen)

    def reward(
        self, reward: FloatArray, following: FloatArray | float
    ) -> tuple[Chosen, FloatArray] | None:
        """Note the reward of the last choice; return the choice of n decisions ago, and its return.

        Parameters
        ----------
        reward: (agents,) float64
        following: (agents,) float64
            Value of the states now, with which returns go on after n rewards.

        Returns
        -------
        chosen, value
            What was noted then, and Σ γᵏ r_k + γⁿ·following, (agents,) float64; None if there are
            no n rewards yet.
        """
        self._rewards.append(reward.astype(np.float64))
        if len(self._rewards) < self._steps:
            return None
        value = self._discounts[-1] * np.broadcast_to(following, reward.shape)
        # A sum that is no number is the caller's to notice.
        with np.errstate(over="ignore", invalid="ignore"):
            for discount, earned in zip(self._discounts[-2::-1], self._rewards[::-1], strict=True):
                value = value + discount * earned
        self._rewards.pop(0)
        return self._chosen.pop(0), value


def best_tried(value: FloatArray) -> FloatArray:
    """Return the largest value of each state that is not infinite, 0 if there is none (ours).

    Parameters
    ----------
    value: (agents, actions) float64
        Infinite where an action was never tried.
    """
    best = np.where(np.isfinite(value), value, -np.inf).max(axis=1)
    found: FloatArray = np.where(np.isfinite(best), best, 0.0)
    return found


def signalled_columns(network: RoadNetwork) -> tuple[IntArray, IntArray]:
    """Return the movements that need a signal (ours).

    Returns
    -------
    columns, there: (intersections, places) int32
        Movements, and 1; both 0 where an intersection has fewer than others.
    """
    needing = [
        [j for j in range(len(item.movements)) if j not in item.unsignalled]
        for item in network.intersections
    ]
    shape = len(needing), max(1, max(map(len, needing)))
    columns, there = np.zeros(shape, np.int32), np.zeros(shape, np.int32)
    for i, movements in enumerate(needing):
        columns[i, : len(movements)] = movements
        there[i, : len(movements)] = 1
    return columns, there


def as_keys(states: IntArray) -> KeyArray:
    """Return states as keys of entries (ours)."""
    return states.astype(np.float32)


@kernel
def choose_all(
    value: FloatArray,
    phase_count: IntArray,
    alike: IntArray,
    draws: FloatArray,
    epsilon: float,
    action: IntArray,
) -> None:
    """Choose ε-greedily for all agents.

    Parameters
    ----------
    value: (agents, actions) float64
    phase_count: (agents,) int32
    alike: (actions,) int32
        0, 1, 2 …
    draws: (agents, 3) float64
        See `dmil.controllers.tabular.choice.DRAWS`.
    epsilon: float
    action: (agents,) int32
        Filled in place.
    """
    for agent in range(value.shape[0]):
        count = phase_count[agent]
        if explores(draws[agent], epsilon):
            action[agent] = uniform_action(draws[agent, 1], count)
        else:
            action[agent] = greedy_action(value[agent], alike, count, draws[agent, 2])
