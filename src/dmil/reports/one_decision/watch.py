"""A controller that notes what its agents had before them whenever they decided."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dmil.controllers import RunContext
from dmil.controllers.tabular.choice import DRAWS
from dmil.controllers.tabular.dual_memory import DualMemoryController
from dmil.memory import DualMemory
from dmil.simulation import Observation

IntArray = npt.NDArray[np.int32]
FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Moment:
    """One decision of all agents.

    Attributes
    ----------
    reward: (agents,) float64 or None
        Reward of the last actions.
    draws: (agents, 3) float64
        See `dmil.controllers.tabular.choice.DRAWS`.
    memory
        As it was before the decision.
    action: (agents,) int32
    """

    observation: Observation
    reward: FloatArray | None
    draws: FloatArray
    memory: DualMemory
    action: IntArray


class Watch:
    """A controller that asks the agents and notes every decision."""

    def __init__(self, agents: DualMemoryController) -> None:
        self.moments: list[Moment] = []
        self._agents = agents

    def reset(self, context: RunContext) -> None:
        """Get ready for a run."""
        self._rng = context.rng
        self._agents.reset(context)

    def decide(self, observation: Observation, reward: FloatArray | None) -> IntArray:
        """Choose what the agents choose."""
        # A copy of the generator draws what the agents are about to draw.
        draws = deepcopy(self._rng).random((observation.queue_veh.shape[0], DRAWS))
        memory = deepcopy(self._agents.memory)
        action = self._agents.decide(observation, reward)
        self.moments.append(Moment(observation, reward, draws, memory, action.copy()))
        return action
