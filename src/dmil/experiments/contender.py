"""Who runs: a controller with its options, or a policy; and what freezes one that has learned."""

from __future__ import annotations

import inspect
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dmil.controllers import CONTROLLERS, Controller, MemoryController, make_controller
from dmil.controllers.variants import Variant
from dmil.importing import import_object
from dmil.network import RoadNetwork
from dmil.rewards import PAPER_CONSTANTS, RewardConstants
from dmil.training import Policy, controller_of, load_policy, policy_of

FROZEN = {"learning": False, "epsilon": 0.0}
"""Options of one that learns no more and always takes the action it holds best."""


@dataclass(frozen=True, slots=True)
class Contender:
    """One controller of a comparison, under the label that tables show.

    A policy is the file of one that was trained: the variant's options go over its own. The reward
    is what it gets if it learns, see `dmil.rewards.make_reward`.
    """

    label: str
    variant: Variant
    policy: str | None = None
    reward: str = "diffusion"
    reward_constants: RewardConstants = PAPER_CONSTANTS

    @classmethod
    def trained(cls, path: Path, policy: Policy, options: Mapping[str, Any]) -> Contender:
        """Return a policy, frozen; some options go over its own."""
        frozen = accepted(policy.controller, FROZEN)
        return cls(path.name, Variant(policy.controller, frozen | dict(options)), str(path))

    def make(self, network: RoadNetwork) -> Controller:
        """Make the controller for a network, with what it has learned."""
        if self.policy is None:
            return make_controller(self.variant.name, self.variant.options)
        policy = load_policy(Path(self.policy))
        return controller_of(policy, network, where=self.policy, **self.variant.options)


def frozen_copy(learner: MemoryController, network: RoadNetwork, variant: Variant) -> Controller:
    """Return a controller that acts on what another one has learned, and learns no more."""
    policy = policy_of(
        learner,
        network,
        name=variant.name,
        options=dict(variant.options),
        reward="",
        training={"scenario": network.name},
    )
    return controller_of(policy, network, where=variant.name, **accepted(variant.name, FROZEN))


def accepted(controller: str, options: Mapping[str, Any]) -> dict[str, Any]:
    """Return those of some options that a controller, by name or import path, has."""
    known: Collection[str] = options  # making it will say what is wrong with it
    if controller in CONTROLLERS:
        settings = CONTROLLERS[controller].settings
        known = settings.model_fields if settings else ()
    elif ":" in controller and callable(found := import_object(controller, "controller")):
        parameters = inspect.signature(found).parameters
        if not any(each.kind is each.VAR_KEYWORD for each in parameters.values()):
            known = parameters
    return {name: value for name, value in options.items() if name in known}
