"""Policies of others as controllers, and controllers as policies of others."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from dmil.controllers import Controller, RunContext
from dmil.errors import InputError
from dmil.interop.intersection import IntersectionEnv
from dmil.interop.layout import VectorLayout
from dmil.interop.traffic_v0 import TrafficEnv
from dmil.seeding import stream
from dmil.simulation import Observation

Predict = Callable[..., Any]


class PredictController:
    """A policy that was trained elsewhere, as a controller of this package.

    It sees what the environments' agents see and does not learn, so that ``dmil evaluate`` can
    judge it: write a function or class without arguments that makes one, and name it by its
    import path.

    Parameters
    ----------
    predict
        Function from an agent's vector to its action, such as the ``predict`` of a model of
        stable-baselines3: it may return a pair whose first part is the action. A mapping from the
        ids of intersections gives each its own.
    padded
        Whether vectors are padded to equal length, as in an environment with ``padded=True``.
    masked
        Whether to call ``predict(vector, action_masks=mask)``, as for sb3-contrib's MaskablePPO.
        The mask holds the phases that exist.
    """

    def __init__(
        self,
        predict: Predict | Mapping[str, Predict],
        *,
        padded: bool = False,
        masked: bool = False,
    ) -> None:
        self._given, self._padded, self._masked = predict, padded, masked

    def reset(self, context: RunContext) -> None:
        """Lay out the vectors of this network.

        Raises
        ------
        InputError
            If an intersection has no policy.
        """
        ids = [item.id for item in context.network.intersections]
        if isinstance(self._given, Mapping):
            missing = next((name for name in ids if name not in self._given), None)
            if missing is not None:
                raise InputError(
                    f"intersection '{missing}' has no policy",
                    where="PredictController",
                    expected="a function for each intersection",
                )
            self._predict = [self._given[name] for name in ids]
        else:
            self._predict = [self._given] * len(ids)
        self._layout = VectorLayout(
            context.network, context.decision_interval_s, padded=self._padded
        )

    def decide(
        self, observation: Observation, reward: np.ndarray[Any, Any] | None
    ) -> np.ndarray[Any, np.dtype[np.int32]]:
        """Ask the policy for every intersection; rewards are of no interest."""
        vectors = self._layout.vectors(observation)
        options: list[dict[str, Any]] = [{}] * len(vectors)
        if self._masked:
            options = [{"action_masks": mask} for mask in self._layout.masks(observation)]
        chosen = [
            predict(vector, **option)
            for predict, vector, option in zip(self._predict, vectors, options, strict=True)
        ]
        actions = [choice[0] if isinstance(choice, tuple) else choice for choice in chosen]
        return np.array([int(action) for action in actions], np.int32)


class ControllerPolicy:
    """A controller of this package in a loop of somebody else's, over our environments.

    Parameters
    ----------
    env
        The environment, wrapped or not; it must be reset before the first action.
    controller
        Begins anew in every episode, with the stream of chance that an evaluation of the episode's
        seed gives it, and gets the rewards of the environment.
    """

    def __init__(self, env: Any, controller: Controller) -> None:
        inner = env.unwrapped
        if not isinstance(inner, TrafficEnv | IntersectionEnv):
            raise InputError(
                f"it is a {type(inner).__name__}",
                where="env",
                expected="an environment of dmil.interop",
            )
        self._single = isinstance(inner, IntersectionEnv)
        self._episodes, self._controller = inner.episodes, controller

    def actions(self) -> Any:
        """Choose for what is seen now: one action, or in PettingZoo one for each agent."""
        episodes = self._episodes
        seen = episodes.observation
        if episodes.rewards is None:
            scenario, rng = episodes.scenario, stream(episodes.seed, "exploration")
            self._controller.reset(
                RunContext(
                    scenario.network, scenario.timing, rng, episodes.vehicles, scenario.dynamics
                )
            )
        phases = self._controller.decide(seen, episodes.rewards).tolist()
        return phases[0] if self._single else dict(zip(episodes.ids, phases, strict=True))
