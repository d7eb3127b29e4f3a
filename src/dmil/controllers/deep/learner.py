"""What the deep controllers share: one decision, from what is seen to what is chosen."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from dmil.arrays import Array, Arrays, FloatArray, IntArray, Single
from dmil.controllers.deep.network import one_thread
from dmil.controllers.deep.settings import DeepSettings
from dmil.controllers.episodic.by_shape import DECISIONS, SharedLearner
from dmil.controllers.protocol import RunContext
from dmil.errors import DivergedError
from dmil.memory.saved import named, part, saved_array
from dmil.simulation import Observation


class NetworkLearner(SharedLearner):
    """One agent per intersection; agents of one shape share a network of neurons.

    Parameters
    ----------
    name
        Name of the controller, for errors.
    settings
        What all deep controllers share.
    """

    def __init__(self, name: str, settings: DeepSettings) -> None:
        super().__init__(name, settings)
        self.settings = settings
        self._time_s = 0

    def states(self, observation: Observation) -> IntArray:
        """Return the states of all agents: (agents, places) int32."""
        states = super().states(observation)
        if not self.settings.phase:
            return states
        phases = np.arange(self._phase_count.max())
        return np.hstack([states, (observation.phase[:, None] == phases).astype(np.int32)])

    @property
    def places(self) -> int:
        """Numbers in a state."""
        return super().places + (int(self._phase_count.max()) if self.settings.phase else 0)

    @property
    def _training_done(self) -> float:
        """Part of the planned training that is over, 0 to 1."""
        return min(1.0, self._decisions / self.settings.training_decisions)

    def _expect_finite(self, numbers: npt.NDArray[np.floating], what: str) -> None:
        if not np.isfinite(numbers).all():
            raise DivergedError(self._name, what, self._time_s)


Part = tuple[Callable[[], Arrays], Callable[[Arrays], None]]
"""What returns the arrays of a part of a learner, and what replaces them."""


class DeepLearner(NetworkLearner):
    """Learns from transitions, from one decision to the next.

    The last interval of a run is not learned from: the horizon cuts a task that goes on, and what
    would have followed is not seen.
    """

    def reset(self, context: RunContext) -> None:
        """Get ready for a run; see `SharedLearner.reset`."""
        super().reset(context)
        self._state, self._action = np.zeros((0, 0), np.int32), np.zeros(0, np.int32)

    def decide(self, observation: Observation, reward: FloatArray | None) -> IntArray:
        """Remember what the last choice led to, learn from memory, choose ε-greedily.

        Raises
        ------
        DivergedError
            If a value is not finite.
        """
        settings, state = self.settings, self.states(observation)
        self._time_s = observation.time_s
        with one_thread():
            if settings.learning and reward is not None:
                with np.errstate(over="ignore"):
                    scaled = (reward * settings.reward_scale).astype(np.float32)
                self._expect_finite(scaled, "scaled rewards")
                self._remember(self._state, self._action, scaled, state)
                if self._decisions % settings.train_every == 0:
                    self._train()
            value = self._values(state)
        self._expect_finite(value, "values of the phases")
        action = self.choose(value.astype(np.float64), observation)
        self._decisions += settings.learning
        self._state, self._action = state, action
        return action

    def arrays(self) -> Arrays:
        """Return networks, moments and transitions as flat arrays."""
        saved: dict[str, Array] = {DECISIONS: np.array(self._decisions, np.int64)}
        for name, (arrays, _) in self._parts().items():
            saved |= named(name, arrays())
        return saved

    def restore(self, arrays: Arrays) -> None:
        """Replace networks, moments and transitions.

        Raises
        ------
        PolicyError
            If the arrays are not those of the same networks, memories and agents.
        """
        decisions = int(saved_array(arrays, DECISIONS, (), np.int64, least=0))
        for name, (_, restore) in self._parts().items():
            restore(part(name, arrays))
        self._decisions = decisions

    @abstractmethod
    def _parts(self) -> dict[str, Part]:
        """Return what is saved, by what the names of its arrays begin with, in their order."""

    @abstractmethod
    def _values(self, state: IntArray) -> Single:
        """Return the values of all agents' phases: (agents, phases), 0 where there is no phase."""

    @abstractmethod
    def _remember(
        self, state: IntArray, action: IntArray, reward: Single, following: IntArray
    ) -> None:
        """Store the transitions of all agents."""

    @abstractmethod
    def _train(self) -> None:
        """Take one step of learning, if there is enough to learn from."""
