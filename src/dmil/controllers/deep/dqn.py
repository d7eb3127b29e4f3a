"""Deep Q-network with experience replay (Mnih et al. 2015), and with prioritised replay.

That is the proportional variant of Schaul et al. (2016). See docs/controllers/dqn.md and
dqn-prioritised.md.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import torch

from dmil.arrays import IntArray, LongArray, Single
from dmil.controllers.deep.learner import DeepLearner, Part
from dmil.controllers.deep.network import QNetwork
from dmil.controllers.deep.settings import DqnSettings, PrioritisedSettings
from dmil.controllers.protocol import MemoryUse
from dmil.memory.replay import Columns, Replay
from dmil.memory.sum_tree import Priorities


@dataclass(frozen=True, slots=True)
class Batch:
    """Transitions to learn from.

    Attributes
    ----------
    rows: (batch,) int64
        Where they are in the replay.
    state, following: (batch, places) int
        Counts before and after.
    action: (batch,) int
    reward: (batch,) float32
    weight: (batch,) float32 or None
        How much each counts; all the same if None.
    """

    rows: LongArray
    state: npt.NDArray[np.integer]
    action: npt.NDArray[np.integer]
    reward: Single
    following: npt.NDArray[np.integer]
    weight: Single | None = None


class DqnController(DeepLearner):
    """One agent per intersection; agents of one shape share a network and a replay.

    Differs from the paper: the inputs are counts, not pictures; the horizon is not taken for an
    end, so every target bootstraps; Adam in place of RMSProp; ε is a part of the planned training.

    Parameters
    ----------
    name
        Name of the controller, for errors.
    """

    settings: DqnSettings

    def __init__(self, settings: DqnSettings | None = None, *, name: str = "dqn") -> None:
        super().__init__(name, settings or DqnSettings())

    def memory_use(self) -> MemoryUse:
        """Return how much is remembered now: the transitions that can be replayed."""
        entries = np.array([self._transitions(shape) for shape in range(len(self._replays))])
        return self.use_of(entries, sum(self._bytes(shape) for shape in range(entries.size)))

    def _start(self) -> None:
        settings, agents = self.settings, self.agents
        phases = [int(self._phase_count[members[0]]) for members in agents.members]
        self._networks = [QNetwork(self._inputs, n, settings, self._rng) for n in phases]
        self._replays = [self._empty_replay(members.size) for members in agents.members]

    @property
    def _inputs(self) -> int:
        """Numbers that a network takes."""
        return self.places

    def _empty_replay(self, members: int) -> Replay:
        columns: Columns = {
            "state": (np.uint16, (self.places,)),
            "action": (np.int16, ()),
            "reward": (np.float32, ()),
            "following": (np.uint16, (self.places,)),
        }
        return Replay(self.settings.buffer_capacity, columns)

    def _values(self, state: IntArray) -> Single:
        value = np.zeros((len(state), self._phase_count.max()), np.float32)
        for network, members in zip(self._networks, self.agents.members, strict=True):
            found = network.values(self._seen(state[members]))
            value[members, : found.shape[1]] = found
        return value

    def _seen(self, state: IntArray) -> IntArray:
        """Return what a network takes to choose: (agents, inputs)."""
        return state

    def _remember(
        self, state: IntArray, action: IntArray, reward: Single, following: IntArray
    ) -> None:
        for shape, members in enumerate(self.agents.members):
            rows = self._replays[shape].append(
                state=state[members],
                action=action[members],
                reward=reward[members],
                following=following[members],
            )
            self._remembered(shape, rows)

    def _train(self) -> None:
        for shape, network in enumerate(self._networks):
            if self._transitions(shape) < self.settings.batch_size:
                continue
            batch = self._sample(shape)
            reward = torch.from_numpy(batch.reward)
            target = reward + self.settings.discount * network.best(batch.following)
            value = network.value_of(batch.state, batch.action)
            if batch.weight is None:
                loss = torch.nn.functional.smooth_l1_loss(value, target)
            else:
                losses = torch.nn.functional.smooth_l1_loss(value, target, reduction="none")
                loss = (losses * torch.from_numpy(batch.weight)).mean()
            error = (target - value.detach()).numpy()
            self._expect_finite(error, "errors of the values")
            network.learn(torch.autograd.grad(loss, network.network.weights)[0])
            self._learned(shape, batch.rows, error)

    def _sample(self, shape: int) -> Batch:
        """Choose transitions to learn from."""
        rows = self._replays[shape].sample(self._rng.random(self.settings.batch_size))
        return self._batch(shape, rows)

    def _batch(self, shape: int, rows: LongArray, weight: Single | None = None) -> Batch:
        take = self._replays[shape].take
        return Batch(
            rows=rows,
            state=take("state", rows),
            action=take("action", rows),
            reward=take("reward", rows),
            following=take("following", rows),
            weight=weight,
        )

    def _remembered(self, shape: int, rows: LongArray) -> None:
        """Take note of new transitions; nothing to note when all are equally likely."""

    def _learned(self, shape: int, rows: LongArray, error: Single) -> None:
        """Take note of the errors of a batch; nothing to note when all are equally likely."""

    def _transitions(self, shape: int) -> int:
        return self._replays[shape].size

    def _bytes(self, shape: int) -> int:
        return self._networks[shape].bytes_used + self._replays[shape].bytes_used

    def _parts(self) -> dict[str, Part]:
        return {
            f"{shape}{name}": each
            for shape in range(len(self._networks))
            for name, each in self._parts_of(shape).items()
        }

    def _parts_of(self, shape: int) -> dict[str, Part]:
        """Return what is saved of a shape: see `_parts`."""
        network, replay = self._networks[shape], self._replays[shape]
        return {"": (network.arrays, network.restore), ".replay": (replay.arrays, replay.restore)}


class PrioritisedController(DqnController):
    """DQN that replays a transition the more often, the larger its last error was.

    Differs from the paper: plain Q-learning targets, not Double DQN's, so that replay is all that
    differs from ``dqn``; weights are divided by the largest of the batch.
    """

    settings: PrioritisedSettings

    def __init__(self, settings: PrioritisedSettings | None = None) -> None:
        super().__init__(settings or PrioritisedSettings(), name="dqn-prioritised")

    def _start(self) -> None:
        super()._start()
        settings = self.settings
        self._priorities = [
            Priorities(
                settings.buffer_capacity, settings.priority_exponent, settings.priority_floor
            )
            for _ in self._replays
        ]

    def _sample(self, shape: int) -> Batch:
        settings = self.settings
        beta = settings.weight_first + self._training_done * (
            settings.weight_last - settings.weight_first
        )
        draws = self._rng.random(settings.batch_size)
        size = self._replays[shape].size
        rows, weight = self._priorities[shape].sample(draws, size, beta)
        return self._batch(shape, rows, weight.astype(np.float32))

    def _remembered(self, shape: int, rows: LongArray) -> None:
        self._priorities[shape].add(rows)

    def _learned(self, shape: int, rows: LongArray, error: Single) -> None:
        self._priorities[shape].update(rows, error)

    def _bytes(self, shape: int) -> int:
        return super()._bytes(shape) + self._priorities[shape].sums.nbytes

    def _parts_of(self, shape: int) -> dict[str, Part]:
        priorities, replay = self._priorities[shape], self._replays[shape]
        own: Part = (
            lambda: priorities.arrays(replay.size),
            lambda arrays: priorities.restore(arrays, replay.size),
        )
        return {**super()._parts_of(shape), ".priorities": own}
