"""What both kinds of environments share: episodes of a scenario in a simulator."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import logger

from dmil.errors import InputError, unknown_name
from dmil.interop.layout import FloatArray, VectorLayout
from dmil.interop.picture import Picture
from dmil.results.metrics import JUDGED
from dmil.rewards import Reward, checked_reward, make_reward
from dmil.scenarios import Scenario, scenario, signal_times
from dmil.scenarios.registry import with_load
from dmil.seeding import simulator_seed
from dmil.simulation import Observation, Simulator, make_simulator
from dmil.training import vehicles_of_seed

RENDER_MODES = ["rgb_array"]
RENDER_FPS = 5
"""Pictures per second of a film: with decisions every 10 s, 50 times as fast as the real thing."""
MOST_DRAWN_SEED = 2**31
"""Seeds that an environment draws by itself are below; test seeds such as 0 … 29 are as good as
never among them."""


class Episodes:
    """Episodes of a scenario, one after the other; for parameters and errors see `TrafficEnv`."""

    def __init__(
        self,
        made: str | Scenario,
        simulator: str | Callable[[Scenario], Simulator],
        reward: str | Reward,
        *,
        horizon_s: int | None,
        load: float,
        padded: bool,
        render_mode: str | None,
    ) -> None:
        if render_mode is not None and render_mode not in RENDER_MODES:
            raise unknown_name("render mode", str(render_mode), RENDER_MODES)
        self.scenario = _scenario(made, horizon_s, load)
        self.reward = make_reward(reward) if isinstance(reward, str) else reward
        network, timing = self.scenario.network, self.scenario.timing
        self.layout = VectorLayout(network, timing.decision_interval_s, padded=padded)
        self.ids = [item.id for item in network.intersections]
        self.render_mode = render_mode
        self.seed = 0
        self.rewards: npt.NDArray[np.float64] | None = None
        self._observation: Observation | None = None
        self._picture: Picture | None = None
        self.simulator = (
            make_simulator(self.scenario, simulator)
            if isinstance(simulator, str)
            else simulator(self.scenario)
        )

    @property
    def observation(self) -> Observation:
        """What is seen now; an `InputError` before the first reset."""
        if self._observation is None:
            raise InputError(
                "no episode has begun", where=self.scenario.name, mend="call reset first"
            )
        return self._observation

    @property
    def over(self) -> bool:
        """Whether the horizon is reached."""
        return self.observation.time_s >= self.simulator.horizon_s

    def begin(self, seed: int) -> None:
        """Begin the episode of a seed: the vehicles and the simulator of an evaluation of it."""
        self.seed = seed
        self.vehicles = vehicles_of_seed(self.scenario, seed)
        self._observation = self.simulator.reset(self.vehicles, simulator_seed(seed))
        self.rewards = None
        self._overruled = np.zeros(len(self.ids), np.int64)
        self._waited_veh_s = np.zeros(len(self.ids), np.int64)

    def advance(self, actions: Sequence[Any]) -> npt.NDArray[np.float64]:
        """Show one phase per intersection for an interval; return the (intersections,) rewards.

        Raises
        ------
        InputError
            If a phase does not exist, no episode is under way, or the reward is not one finite
            number per intersection.
        """
        before = self.observation
        phases = self._checked(actions)
        after = self.simulator.advance(phases)
        rewards = checked_reward(self.reward, before, after, self.scenario.network)
        self._overruled += after.phase != phases
        seconds = after.time_s - before.time_s
        self._waited_veh_s += seconds * after.queue_veh.sum(axis=1)
        self._observation, self.rewards = after, rewards
        return rewards

    def _checked(self, actions: Sequence[Any]) -> npt.NDArray[np.int32]:
        """Return the actions as phases; numbers of any library may be whole numbers."""
        phases = np.zeros(len(self.ids), np.int32)
        for i, (action, count) in enumerate(zip(actions, self.layout.phases, strict=True)):
            try:
                phase = operator.index(action)
            except TypeError:
                phase = -1
            if not 0 <= phase < count:
                raise InputError(
                    f"the action is {action!r}",
                    where=f"intersection '{self.ids[i]}'",
                    expected=f"one of its phases, a whole number from 0 to {count - 1}",
                    mend="choose where info['action_mask'] is 1",
                )
            phases[i] = phase
        return phases

    def vectors(self) -> list[FloatArray]:
        """Return what every intersection's agent sees now."""
        return self.layout.vectors(self.observation)

    def infos(self) -> list[dict[str, Any]]:
        """Return what is to be known about every intersection; at the horizon the metrics, too."""
        seen, over = self.observation, self.over
        times = signal_times(self.scenario.timing, self.scenario.network)
        masks = self.layout.masks(seen, times.min_green_s, times.max_green_s)
        columns: dict[str, list[Any]] = {
            "action_mask": masks,
            "queue_veh": seen.queue_veh.sum(axis=1).tolist(),
            "waited_veh_s": self._waited_veh_s.tolist(),
            "phase": seen.phase.tolist(),
            "phase_elapsed_s": seen.phase_elapsed_s.tolist(),
            "overruled": self._overruled.tolist(),
        }
        rows = zip(*columns.values(), strict=True)
        infos: list[dict[str, Any]] = [dict(zip(columns, row, strict=True)) for row in rows]
        measures = self.measures() if over else {}
        for info in infos:
            info["time_s"], info["seed"] = seen.time_s, self.seed
            if over:
                info["measures"] = dict(measures)
        return infos

    def measures(self) -> dict[str, float]:
        """Return the metrics of the episode so far that are known, of `dmil.results.metrics`."""
        measures = self.simulator.measures()
        found = {name: float(getattr(measures, name)) for name in JUDGED}
        return {name: value for name, value in found.items() if not math.isnan(value)}

    def render(self) -> npt.NDArray[np.uint8] | None:
        """Draw what is seen now: (height, width, 3) uint8."""
        if self.render_mode is None:
            logger.warn("render() was called without render_mode='rgb_array'")
            return None
        if self._picture is None:
            self._picture = Picture(self.scenario.network)
        return self._picture.draw(self.observation, self.scenario.name)

    def close(self) -> None:
        """End the simulator; may be called more than once."""
        close = getattr(self.simulator, "close", None)
        if close:
            close()


class OfEpisodes:
    """What the environments of both interfaces do in the same way."""

    episodes: Episodes

    def render(self) -> npt.NDArray[np.uint8] | None:
        """Draw the network as it stands: (height, width, 3) uint8."""
        return self.episodes.render()

    def close(self) -> None:
        """End the simulator; may be called more than once."""
        self.episodes.close()

    def _begin(self, seed: int | None, rng: np.random.Generator) -> None:
        """Begin the episode of a seed, or of one that is drawn."""
        self.episodes.begin(int(rng.integers(MOST_DRAWN_SEED)) if seed is None else int(seed))


def _scenario(made: str | Scenario, horizon_s: int | None, load: float) -> Scenario:
    if isinstance(made, str):
        return scenario(made, horizon_s=horizon_s, load=load)
    made = with_load(made, load)
    return made if horizon_s is None else replace(made, horizon_s=horizon_s)
