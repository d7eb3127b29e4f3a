"""Value decomposition network (Sunehag et al. 2018).

See docs/controllers/vdn.md.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import torch

from dmil.arrays import IntArray, Single
from dmil.controllers.deep.learner import DeepLearner, Part
from dmil.controllers.deep.network import QNetwork, features
from dmil.controllers.deep.settings import VdnSettings
from dmil.controllers.protocol import MemoryUse, RunContext
from dmil.errors import PolicyError
from dmil.memory.replay import Columns, Replay

Counts = npt.NDArray[np.integer]


class VdnController(DeepLearner):
    """Agents that learn one value together: Q_tot = Σ_i Q_i(o_i, a_i), one error on the sum.

    The team's reward is the sum of all intersections' rewards. Each agent chooses by its own Q_i,
    which together maximise the sum. Agents of one shape share a network, which also sees which of
    them it is.

    Differs from the paper: no recurrent layers and no dueling heads; agents of different shapes
    have different networks.
    """

    settings: VdnSettings

    def __init__(self, settings: VdnSettings | None = None) -> None:
        super().__init__("vdn", settings or VdnSettings())

    def reset(self, context: RunContext) -> None:
        """Get ready for a run; see `SharedLearner.reset`.

        Raises
        ------
        PolicyError
            If this controller learned on another network.
        """
        before = self._agents
        super().reset(context)
        if before is not None and not np.array_equal(before.shape, self.agents.shape):
            raise PolicyError(
                "it learned with other intersections",
                where=f"controller on network '{context.network.name}'",
                expected="the network that it learned on, where each agent has its place",
                mend="make a new controller for another network",
            )

    def memory_use(self) -> MemoryUse:
        """Return how much is remembered now: the team's transitions that can be replayed."""
        size = self._replay.size
        own = self._guard.bytes_total + sum(each.bytes_used for each in self._networks)
        return MemoryUse(0.0, 0.0, size, size, size, own + self._replay.bytes_used)

    def _parts(self) -> dict[str, Part]:
        networks = {str(i): (each.arrays, each.restore) for i, each in enumerate(self._networks)}
        return {**networks, "replay": (self._replay.arrays, self._replay.restore)}

    def _start(self) -> None:
        settings, members = self.settings, self.agents.members
        self._networks = [
            QNetwork(self.places + of.size, int(self._phase_count[of[0]]), settings, self._rng)
            for of in members
        ]
        # Which member of its shape an agent is.
        self._index = [torch.eye(of.size, dtype=torch.float32) for of in members]
        agents = self.agents.shape.size
        columns: Columns = {
            "state": (np.uint16, (agents, self.places)),
            "action": (np.int16, (agents,)),
            "reward": (np.float32, ()),
            "following": (np.uint16, (agents, self.places)),
        }
        self._replay = Replay(settings.buffer_capacity, columns)

    def _values(self, state: IntArray) -> Single:
        value = np.zeros((len(state), self._phase_count.max()), np.float32)
        for shape, members in enumerate(self.agents.members):
            with torch.no_grad():
                found = self._networks[shape].network(self._seen(state[None], shape)).numpy()
            value[members, : found.shape[1]] = found
        return value

    def _seen(self, state: Counts, shape: int) -> Any:
        """Return what a shape's network takes: (batch · members, inputs) float32 tensor.

        Parameters
        ----------
        state: (batch, agents, places) int
        shape: int
        """
        index = self._index[shape]
        mine = features(state[:, self.agents.members[shape]])
        who = index.expand(len(state), *index.shape)
        return torch.cat([mine, who], 2).flatten(0, 1)

    def _remember(
        self, state: IntArray, action: IntArray, reward: Single, following: IntArray
    ) -> None:
        self._replay.append(
            state=state[None],
            action=action[None],
            reward=reward.sum(keepdims=True),
            following=following[None],
        )

    def _train(self) -> None:
        settings, replay, networks = self.settings, self._replay, self._networks
        if replay.size < settings.batch_size:
            return
        rows = replay.sample(self._rng.random(settings.batch_size))
        state, following = replay.take("state", rows), replay.take("following", rows)
        action = torch.from_numpy(replay.take("action", rows).astype(np.int64))
        team, best = torch.zeros(rows.size), torch.zeros(rows.size)
        for shape, (network, members) in enumerate(zip(networks, self.agents.members, strict=True)):
            own = network.network(self._seen(state, shape))
            chosen = own.gather(1, action[:, members].reshape(-1, 1))
            team = team + chosen.view(rows.size, -1).sum(1)
            with torch.no_grad():
                others = network.network(self._seen(following, shape), network.target)
                best += others.amax(1).view(rows.size, -1).sum(1)
        target = torch.from_numpy(replay.take("reward", rows)) + settings.discount * best
        self._expect_finite((target - team.detach()).numpy(), "errors of the values")
        loss = torch.nn.functional.smooth_l1_loss(team, target)
        weights = [network.network.weights for network in networks]
        for network, gradient in zip(networks, torch.autograd.grad(loss, weights), strict=True):
            network.learn(gradient)
