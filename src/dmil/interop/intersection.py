"""Gymnasium environment: one intersection, and the names under which Gymnasium finds it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Discrete

from dmil.errors import InputError
from dmil.interop.episodes import RENDER_FPS, RENDER_MODES, Episodes, OfEpisodes
from dmil.interop.layout import FloatArray
from dmil.rewards import Reward
from dmil.scenarios import Scenario
from dmil.simulation import Simulator


class IntersectionEnv(OfEpisodes, gymnasium.Env):  # type: ignore[misc]  # mypy skips Gymnasium
    """The one intersection of a scenario (Gymnasium's interface).

    It sees a vector (`VectorLayout`) and chooses one of its phases; at the horizon the episode is
    truncated.

    Parameters
    ----------
    scenario
        Name of a scenario with one intersection, or such a scenario.
    simulator
        Name of the simulator, or a function that makes one for a scenario.
    reward
        Name or import path of the reward, or a function as `dmil.rewards.Reward` describes.
    horizon_s
        Length of an episode in s; by default the scenario's own.
    load
        Factor on the demand.
    render_mode
        ``"rgb_array"`` for pictures, or None.

    Raises
    ------
    InputError
        If the scenario has several intersections, or there is no such scenario, simulator, reward
        or render mode.
    """

    metadata = {  # noqa: RUF012  Gymnasium's own declaration
        "render_modes": RENDER_MODES,
        "render_fps": RENDER_FPS,
    }

    def __init__(
        self,
        scenario: str | Scenario = "grid:1x1",
        simulator: str | Callable[[Scenario], Simulator] = "queue",
        reward: str | Reward = "queue",
        *,
        horizon_s: int | None = None,
        load: float = 1.0,
        render_mode: str | None = None,
    ) -> None:
        self.episodes = Episodes(
            scenario,
            simulator,
            reward,
            horizon_s=horizon_s,
            load=load,
            padded=False,
            render_mode=render_mode,
        )
        if len(self.episodes.ids) != 1:
            self.episodes.close()
            raise InputError(
                f"it has {len(self.episodes.ids)} intersections",
                where=f"scenario {self.episodes.scenario.name}",
                expected="one: this environment has a single agent",
                mend="use dmil.interop.parallel_env for several",
            )
        self.render_mode = render_mode
        high = self.episodes.layout.highest(0)
        self.observation_space = Box(np.zeros_like(high), high, dtype=np.float32)
        self.action_space = Discrete(self.episodes.layout.actions[0])

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[FloatArray, dict[str, Any]]:
        """Begin an episode.

        Parameters
        ----------
        seed
            The episode meets the vehicles that ``dmil evaluate --seed`` of this number meets, and
            the following episodes depend on it. Without one, the seed is drawn; it is in the info.
        options
            There are none.
        """
        super().reset(seed=seed)
        self._begin(seed, self.np_random)
        return self.episodes.vectors()[0], self.episodes.infos()[0]

    def step(self, action: Any) -> tuple[FloatArray, float, bool, bool, dict[str, Any]]:
        """Show a phase for one decision interval.

        Raises
        ------
        InputError
            If there is no such phase, or no episode is under way.
        """
        episodes = self.episodes
        reward = float(episodes.advance([action])[0])
        return episodes.vectors()[0], reward, False, episodes.over, episodes.infos()[0]


SINGLE = {"1x1": "grid:1x1", "Cologne1": "resco/cologne1", "Ingolstadt1": "resco/ingolstadt1"}
"""Scenarios with one intersection, by what they are called in a registered name."""

ENVIRONMENTS: dict[str, dict[str, str]] = {
    f"dmil/{simulator.capitalize()}{called}-v0": {"scenario": scenario, "simulator": simulator}
    for simulator in ("queue", "sumo")
    for called, scenario in SINGLE.items()
}
"""The registered names and what they stand for; other parameters go to ``gymnasium.make``."""


def register_environments() -> None:
    """Make the names known to Gymnasium; nothing happens if they are."""
    for name, options in ENVIRONMENTS.items():
        if name not in gymnasium.registry:
            gymnasium.register(
                name, entry_point="dmil.interop.intersection:IntersectionEnv", kwargs=dict(options)
            )
