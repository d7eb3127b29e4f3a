"""PettingZoo environments: every intersection of a scenario is an agent."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Discrete
from gymnasium.utils.seeding import np_random
from pettingzoo import AECEnv, ParallelEnv
from pettingzoo.utils.conversions import parallel_to_aec

from dmil.errors import InputError, unknown_name
from dmil.interop.episodes import RENDER_FPS, RENDER_MODES, Episodes, OfEpisodes
from dmil.interop.layout import FloatArray
from dmil.rewards import Reward
from dmil.scenarios import Scenario
from dmil.simulation import Simulator

Infos = dict[str, dict[str, Any]]


class TrafficEnv(OfEpisodes, ParallelEnv):  # type: ignore[misc]  # PettingZoo is not typed
    """All intersections of a scenario decide at once (PettingZoo's parallel interface).

    Agents are the ids of the intersections. An agent sees a vector (`VectorLayout`) and chooses
    one of its phases. At the horizon all agents are truncated: the task goes on, it is no terminal
    state.

    Parameters
    ----------
    scenario
        Name of a scenario, such as ``grid:5x5``, or a scenario.
    simulator
        Name of the simulator (`dmil.simulation.SIMULATORS`), or a function that makes one for a
        scenario.
    reward
        Name or import path of the reward, or a function as `dmil.rewards.Reward` describes.
    horizon_s
        Length of an episode in s; by default the scenario's own.
    load
        Factor on the demand.
    padded
        Give all agents vectors and action spaces of equal size, for algorithms that share their
        parameters; what an agent does not have is 0 in its vector and in its action mask.
    render_mode
        ``"rgb_array"`` for pictures, or None.

    Raises
    ------
    InputError
        If there is no such scenario, simulator, reward or render mode.
    """

    metadata = {  # noqa: RUF012  PettingZoo's own declaration
        "name": "traffic_v0",
        "render_modes": RENDER_MODES,
        "render_fps": RENDER_FPS,
        "is_parallelizable": True,
    }

    def __init__(
        self,
        scenario: str | Scenario = "grid:3x3",
        simulator: str | Callable[[Scenario], Simulator] = "queue",
        reward: str | Reward = "queue",
        *,
        horizon_s: int | None = None,
        load: float = 1.0,
        padded: bool = False,
        render_mode: str | None = None,
    ) -> None:
        self.episodes = Episodes(
            scenario,
            simulator,
            reward,
            horizon_s=horizon_s,
            load=load,
            padded=padded,
            render_mode=render_mode,
        )
        self.render_mode = render_mode
        self.possible_agents = list(self.episodes.ids)
        self.agents: list[str] = []
        layout = self.episodes.layout
        highest = [layout.highest(i) for i in range(len(self.possible_agents))]
        self._observation_space = {
            agent: Box(np.zeros_like(high), high, dtype=np.float32)
            for agent, high in zip(self.possible_agents, highest, strict=True)
        }
        self._action_space = {
            agent: Discrete(count)
            for agent, count in zip(self.possible_agents, layout.actions, strict=True)
        }
        high = np.concatenate(highest)
        self.state_space = Box(np.zeros_like(high), high, dtype=np.float32)
        self._rng: np.random.Generator | None = None

    def observation_space(self, agent: str) -> Box:
        """Return what an agent may see; see `VectorLayout`."""
        return self._observation_space[agent]

    def action_space(self, agent: str) -> Discrete:
        """Return an agent's phases; padded, the largest number of phases of any agent."""
        return self._action_space[agent]

    def reset(
        self, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[dict[str, FloatArray], Infos]:
        """Begin an episode.

        Parameters
        ----------
        seed
            The episode meets the vehicles that ``dmil evaluate --seed`` of this number meets, and
            the following episodes depend on it. Without one, the seed is drawn; it is in the infos.
        options
            There are none.
        """
        if self._rng is None or seed is not None:
            self._rng, _ = np_random(seed)
        self._begin(seed, self._rng)
        self.agents = self.possible_agents.copy()
        return self._by_agent(self.episodes.vectors()), self._by_agent(self.episodes.infos())

    def step(
        self, actions: Mapping[str, Any]
    ) -> tuple[dict[str, FloatArray], dict[str, float], dict[str, bool], dict[str, bool], Infos]:
        """Show the phase that each agent has chosen for one decision interval.

        Raises
        ------
        InputError
            If an agent is missing or not there, or a phase does not exist.
        """
        ids = self.possible_agents
        if actions.keys() != self._action_space.keys():
            self._explain(actions)
        rewards = self.episodes.advance([actions[agent] for agent in ids])
        over = self.episodes.over
        if over:
            self.agents = []
        return (
            self._by_agent(self.episodes.vectors()),
            self._by_agent(rewards.tolist()),
            dict.fromkeys(ids, False),
            dict.fromkeys(ids, over),
            self._by_agent(self.episodes.infos()),
        )

    def _by_agent(self, values: list[Any]) -> dict[str, Any]:
        return dict(zip(self.possible_agents, values, strict=True))

    def _explain(self, actions: Mapping[str, Any]) -> None:
        """Raise the error for actions that are not one per agent."""
        for agent in actions:
            if agent not in self._action_space:
                raise unknown_name("agent", str(agent), self.possible_agents, where="actions")
        missing = next(agent for agent in self.possible_agents if agent not in actions)
        raise InputError(
            f"agent '{missing}' has no action" if self.agents else "the episode is over",
            where="step",
            expected="one action for each agent",
            mend=None if self.agents else "call reset",
        )

    def state(self) -> FloatArray:
        """Return the vectors of all agents, one after the other."""
        return np.concatenate(self.episodes.vectors())

    def __enter__(self) -> TrafficEnv:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()


parallel_env = TrafficEnv
"""Makes a PettingZoo environment in which all agents decide at once, as PettingZoo calls it."""


def env(
    scenario: str | Scenario = "grid:3x3",
    simulator: str | Callable[[Scenario], Simulator] = "queue",
    reward: str | Reward = "queue",
    **options: Any,
) -> AECEnv:
    """Make a PettingZoo environment in which agents decide one after the other.

    It is PettingZoo's own conversion of `parallel_env`, with the same parameters: the network moves
    on when the last agent has chosen.
    """
    return parallel_to_aec(parallel_env(scenario, simulator, reward, **options))
