"""Runs of a controller under watch: what it chooses, from what, and what it leaves alone."""

from __future__ import annotations

from collections.abc import Callable
from enum import StrEnum

import numpy as np

from dmil.arrays import FloatArray, IntArray
from dmil.controllers import Controller, RunContext
from dmil.network import RoadNetwork
from dmil.rewards import Reward, diffusion
from dmil.scenarios import Scenario
from dmil.seeding import stream
from dmil.simulation import Observation, QueueSimulator
from dmil.testing.conformance import Witness, array_in_words
from dmil.training import run, vehicles_of_seed

MEMORY_VERBS = ("memory_use", "arrays", "restore")


class ControllerRule(StrEnum):
    """What every controller keeps; the last five are for those with a memory."""

    VERBS = "it has the methods reset(context) and decide(observation, reward)"
    FRESH = "every call of make gives a new controller"
    RUNS = "reset and decide work on every network, run after run, whatever the rewards"
    PHASES = "decide returns an array with one whole number per intersection"
    EXISTING = "it chooses phases that the intersection has"
    INPUTS = "it does not change the observation or the reward that it is given"
    CHANCE = "chance comes only from the generator that reset was given for this run"
    REPEAT = "new controllers with equal generators choose equal phases in equal runs"
    MEMORY_VERBS = "it has all of memory_use, arrays and restore, or none"
    MEMORY_USE = "memory_use counts what is remembered, and only looks"
    ARRAYS = "arrays() gives named numpy arrays of plain numbers that a file can hold"
    SNAPSHOT = "what arrays() gave, and what restore took, does not change in later runs"
    RESTORE = "a new controller that restored the arrays decides like the old one"


class Trial:
    """A scenario with its vehicles, on which controllers that are made run and are watched."""

    def __init__(self, make: Callable[[], object], scenario: Scenario) -> None:
        self._make, self._scenario = make, scenario
        self.name, self.network = scenario.name, scenario.network
        self._simulator = QueueSimulator(scenario)
        self._vehicles = vehicles_of_seed(scenario, 0)
        self.witness = Witness(getattr(make, "__qualname__", repr(make)))

    def make(self) -> Controller:
        """Make a controller and check its verbs."""
        witness = self.witness
        with witness.no_exception(ControllerRule.FRESH, "make()"):
            made = self._make()
        witness.subject = type(made).__name__
        missing = [verb for verb in ("reset", "decide") if not callable(getattr(made, verb, None))]
        witness.expect(
            not missing,
            ControllerRule.VERBS,
            f"no method {' and no method '.join(missing)}",
            "methods reset(context) and decide(observation, reward)",
        )
        there = [verb for verb in MEMORY_VERBS if callable(getattr(made, verb, None))]
        witness.expect(
            len(there) in (0, len(MEMORY_VERBS)),
            ControllerRule.MEMORY_VERBS,
            f"only {' and '.join(there)}",
            f"{', '.join(MEMORY_VERBS)}, or none of them for a controller without memory",
        )
        controller: Controller = made  # type: ignore[assignment]
        return controller

    def context(self, rng: np.random.Generator) -> RunContext:
        """Return what a controller is told before a run."""
        return RunContext(
            self.network, self._scenario.timing, rng, self._vehicles, self._scenario.dynamics
        )

    def run(
        self,
        controller: Controller,
        label: str,
        rng: np.random.Generator,
        reward: Reward = diffusion,
        *,
        after_decision: Callable[[], None] | None = None,
    ) -> list[IntArray]:
        """Run a controller under watch; return the (intersections,) phases of every decision.

        The label says in errors which run it is; ``after_decision`` is called after every decision.
        """
        watch = RunWatch(controller, self.witness, f"{label} on {self.name}", after_decision)
        run(self._simulator, watch, self._vehicles, reward, rng)
        return watch.phases

    def expect_same_phases(
        self, expected: list[IntArray], found: list[IntArray], rule: ControllerRule, model: str
    ) -> None:
        """Check that two runs chose the same."""
        interval_s = self._scenario.timing.decision_interval_s
        for k, (one, other) in enumerate(zip(expected, found, strict=True)):
            if (one != other).any():
                i = int((one != other).argmax())
                self.witness.where = f"decision {k + 1} ({k * interval_s} s) on {self.name}"
                told = f"phase {other[i]} at intersection '{self.network.intersections[i].id}'"
                self.witness.fail(rule, told, f"phase {one[i]}, as in {model}")


class RunWatch:
    """A controller that is looked at while it runs; itself a controller, see `Trial.run`."""

    def __init__(
        self,
        inner: Controller,
        witness: Witness,
        place: str,
        after_decision: Callable[[], None] | None,
    ) -> None:
        self._inner, self._witness, self._place = inner, witness, place
        self._after_decision = after_decision
        self.phases: list[IntArray] = []

    def reset(self, context: RunContext) -> None:
        """Begin, and note what the intersections have."""
        self._intersections = context.network.intersections
        self._phase_count = np.array([len(item.phases) for item in self._intersections])
        self._witness.where = f"reset of {self._place}"
        with (
            self._witness.no_exception(ControllerRule.RUNS, "reset"),
            self._witness.no_global_chance(ControllerRule.CHANCE),
        ):
            self._inner.reset(context)

    def decide(self, observation: Observation, reward: FloatArray | None) -> IntArray:
        """Decide, and check everything that can be seen."""
        witness = self._witness
        count = len(self.phases) + 1
        witness.where = f"decision {count} ({observation.time_s} s) of {self._place}"
        with (
            witness.no_exception(ControllerRule.RUNS, "decide"),
            witness.no_global_chance(ControllerRule.CHANCE),
            witness.no_change(ControllerRule.INPUTS, observation=observation, reward=reward),
        ):
            phases = self._inner.decide(observation, reward)
        self._expect_phases(phases)
        self.phases.append(phases.copy())
        if self._after_decision:
            self._after_decision()
        return phases

    def _expect_phases(self, phases: object) -> None:
        count = self._phase_count
        if not (
            isinstance(phases, np.ndarray)
            and phases.shape == count.shape
            and phases.dtype.kind in "iu"
        ):
            self._witness.fail(
                ControllerRule.PHASES,
                array_in_words(phases),
                f"an array of shape {count.shape} and type int32",
            )
        wrong = (phases < 0) | (phases >= count)
        i = int(wrong.argmax())
        self._witness.expect(
            not wrong[i],
            ControllerRule.EXISTING,
            f"phase {phases[i]} at intersection '{self._intersections[i].id}'",
            f"a phase from 0 to {count[i] - 1}",
        )


def chance(name: str) -> np.random.Generator:
    """Return a new generator; the same name gives the same numbers."""
    return stream(0, "conformance", name)


def no_reward(before: Observation, after: Observation, network: RoadNetwork) -> FloatArray:
    """Return 0 for every intersection."""
    return np.zeros(len(network.intersections))
