"""Deep Q-network with goals and hindsight replay (Andrychowicz et al. 2017): an ablation.

See docs/controllers/dqn-hindsight.md.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dmil.arrays import IntArray, Single
from dmil.controllers.deep.dqn import Batch, DqnController
from dmil.controllers.deep.learner import Part
from dmil.controllers.deep.settings import HindsightSettings
from dmil.controllers.protocol import RunContext
from dmil.memory.replay import Columns, Replay, Runs


class HindsightController(DqnController):
    """DQN that learns to keep the worst queue within a goal, for any goal.

    The reward is 0 if no queue is longer than the goal and −1 otherwise; the reward of the run is
    not looked at. The replay keeps one row per decision, all agents of the shape in it, and goals
    are exchanged when a transition is sampled: k of k + 1 times for the worst queue that followed
    it or a later transition of its run (strategy "future").

    Differs from the paper: DQN instead of DDPG; goals are exchanged at sampling instead of storing
    every transition k + 1 times, which has the same distribution and needs less memory.
    """

    settings: HindsightSettings

    def __init__(self, settings: HindsightSettings | None = None) -> None:
        super().__init__(settings or HindsightSettings(), name="dqn-hindsight")

    def reset(self, context: RunContext) -> None:
        """Get ready for a run; see `SharedLearner.reset`."""
        super().reset(context)
        if self.settings.learning:
            for runs, replay in zip(self._runs, self._replays, strict=True):
                runs.begin(replay.written)

    def _start(self) -> None:
        super()._start()
        self._runs = [Runs(replay.capacity) for replay in self._replays]

    @property
    def _inputs(self) -> int:
        return self.places + 1

    def _empty_replay(self, members: int) -> Replay:
        columns: Columns = {
            "state": (np.uint16, (members, self.places)),
            "action": (np.int16, (members,)),
            "following": (np.uint16, (members, self.places)),
        }
        return Replay(max(1, self.settings.buffer_capacity // members), columns)

    def _seen(self, state: IntArray) -> IntArray:
        return _with_goal(state, np.full(len(state), self.settings.goal_veh, np.int32))

    def _remember(
        self, state: IntArray, action: IntArray, reward: Single, following: IntArray
    ) -> None:
        for shape, members in enumerate(self.agents.members):
            self._replays[shape].append(
                state=state[members][None],
                action=action[members][None],
                following=following[members][None],
            )

    def _sample(self, shape: int) -> Batch:
        settings, replay = self.settings, self._replays[shape]
        draws = self._rng.random((4, settings.batch_size))
        rows = replay.sample(draws[0])
        each = np.arange(rows.size)
        agent = (draws[1] * self.agents.members[shape].size).astype(np.int64)
        following = replay.take("following", rows)[each, agent]
        later = self._runs[shape].future(rows, draws[2], replay.written)
        reached = self._worst(replay.take("following", later)[each, agent])
        exchanged = draws[3] * (settings.relabelled + 1) < settings.relabelled
        goal = np.where(exchanged, reached, settings.goal_veh)
        return Batch(
            rows=rows,
            state=_with_goal(replay.take("state", rows)[each, agent], goal),
            action=replay.take("action", rows)[each, agent],
            reward=np.where(self._worst(following) <= goal, 0.0, -1.0).astype(np.float32),
            following=_with_goal(following, goal),
        )

    def _worst(self, state: npt.NDArray[np.integer]) -> npt.NDArray[np.int64]:
        """Return the longest queue of each state."""
        queues = self._columns.shape[1]
        worst: npt.NDArray[np.int64] = state[:, :queues].max(axis=1).astype(np.int64)
        return worst

    def _transitions(self, shape: int) -> int:
        return self._replays[shape].size * self.agents.members[shape].size

    def _parts_of(self, shape: int) -> dict[str, Part]:
        runs, replay = self._runs[shape], self._replays[shape]
        own: Part = runs.arrays, lambda arrays: runs.restore(arrays, replay.written)
        return {**super()._parts_of(shape), ".runs": own}


def _with_goal(state: npt.NDArray[np.integer], goal: npt.NDArray[np.integer]) -> IntArray:
    return np.column_stack([state, goal]).astype(np.int32)
