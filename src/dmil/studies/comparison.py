"""Compare controllers on one scenario: the same vehicles for all in each seed."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from itertools import count
from pathlib import Path

import numpy as np
import numpy.typing as npt

from dmil.controllers import Controller, make_controller
from dmil.network import RoadNetwork
from dmil.rewards import PAPER_CONSTANTS, RewardConstants, make_reward
from dmil.scenarios import Scenario
from dmil.scenarios.recipe import ScenarioRecipe
from dmil.seeding import stream
from dmil.simulation import Simulator, make_simulator
from dmil.statistics import Estimate, mean_interval, paired_difference
from dmil.studies.block import Row, measures_row
from dmil.studies.executors import Executor, LocalExecutor
from dmil.training import controller_of, evaluate, load_policy, vehicles_of_seed

REFERENCE = "max-pressure"
"""Whom differences are taken to, unless another is named."""
DETERMINISTIC = ("fixed-cycle", "program", "longest-queue-first", "max-pressure")
"""Controllers that draw nothing: on the same vehicles they do the same."""


@dataclass(frozen=True, slots=True)
class Contender:
    """One controller of a comparison.

    Parameters
    ----------
    label
        What the table calls it.
    controller
        Its name or import path; not used with a policy.
    options
        Its options as JSON, which go over those of the policy.
    policy
        File that it was saved in, if it was trained.
    reward, reward_constants
        What it gets if it learns, see `dmil.rewards.make_reward`.
    """

    label: str
    controller: str = ""
    options: str = "{}"
    policy: str | None = None
    reward: str = "diffusion"
    reward_constants: RewardConstants = PAPER_CONSTANTS

    def make(self, network: RoadNetwork) -> Controller:
        """Make the controller for a network, with what it has learned (ours)."""
        options = json.loads(self.options)
        if self.policy is None:
            return make_controller(self.controller, options)
        return controller_of(load_policy(Path(self.policy)), network, where=self.policy, **options)


Item = tuple[Contender, int]
_CALLS = count()


@dataclass(frozen=True, slots=True)
class Comparison:
    """Measures of all contenders, and what they say.

    Attributes
    ----------
    labels: list of str
        Contenders.
    seeds: range
    measures: dict
        Measure to (seeds, contenders) float64.
    same_demand: bool
        Whether the vehicles are the same in every seed, so that only chance inside the
        controllers differs.
    exact: bool
        Whether the simulator itself draws nothing.
    reference: str
        Label of the contender that differences are taken to.
    """

    labels: list[str]
    seeds: range
    measures: dict[str, npt.NDArray[np.float64]]
    same_demand: bool
    exact: bool = True
    reference: str = REFERENCE

    def mean(self, measure: str) -> Estimate:
        """Return the mean over seeds with its interval, for every contender (ours)."""
        values = self.measures[measure]
        estimate = mean_interval(values, stream(0, "bootstrap", "comparison", measure))
        return self._with_exact(estimate, self._exact())

    def difference(self, measure: str) -> Estimate | None:
        """Return the paired difference to the reference, None if that is not here (ours)."""
        if self.reference not in self.labels:
            return None
        values = self.measures[measure]
        reference = self.labels.index(self.reference)
        estimate = paired_difference(
            values,
            values[:, [reference]],
            stream(0, "bootstrap", "comparison", measure),
        )
        exact = self._exact()
        return self._with_exact(estimate, exact & exact[reference])

    def _exact(self) -> npt.NDArray[np.bool_]:
        certain = self.same_demand and self.exact
        names = [label.partition(",")[0] for label in self.labels]
        return np.array([certain and name in DETERMINISTIC for name in names])

    @staticmethod
    def _with_exact(estimate: Estimate, exact: npt.NDArray[np.bool_]) -> Estimate:
        """Give what cannot vary an interval of no width, also where there is but one seed."""
        low, high = (np.where(exact, estimate.value, end) for end in (estimate.low, estimate.high))
        return Estimate(estimate.value, low, high, estimate.seeds)


def compare(
    recipe: ScenarioRecipe,
    contenders: Sequence[Contender],
    seeds: range,
    *,
    simulator: str = "queue",
    emissions: bool = False,
    reference: str = REFERENCE,
    executor: Executor | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Comparison:
    """Run every contender in every seed, on the same vehicles in a seed (ours).

    Parameters
    ----------
    recipe
        Where.
    contenders
        Who; every run begins with what the contender had learned before, so seeds are independent.
    seeds
        Test seeds.
    simulator, emissions
        See `dmil.simulation.make_simulator`.
    reference
        Label of the contender that differences are taken to.
    executor
        Where runs happen; processes of this machine by default.
    progress
        Called with the number of finished runs and of all.
    """
    made = recipe.build()
    for contender in contenders:
        contender.make(made.network)  # what is wrong with one shall show before the first run
    items = [(contender, seed) for contender in contenders for seed in seeds]
    place = {item: i for i, item in enumerate(items)}
    rows: list[Row] = [{}] * len(items)
    done = 0
    if progress:
        progress(done, len(items))
    run = partial(_run, recipe.model_dump_json(), simulator, emissions, next(_CALLS))
    for item, row in (executor or LocalExecutor()).map(run, items):
        rows[place[item]] = row
        done += 1
        if progress:
            progress(done, len(items))
    shape = len(contenders), len(seeds)
    return Comparison(
        labels=[contender.label for contender in contenders],
        seeds=seeds,
        measures={
            name: np.array([row[name] for row in rows], np.float64).reshape(shape).T
            for name in rows[0]
        },
        same_demand=has_same_demand(made, seeds[0]),
        exact=simulator == "queue",
        reference=reference,
    )


def has_same_demand(scenario: Scenario, seed: int) -> bool:
    """Tell whether the vehicles are the same in every seed, as recorded ones are (ours)."""
    one, other = vehicles_of_seed(scenario, seed), vehicles_of_seed(scenario, seed + 1)
    return all(
        np.array_equal(getattr(one, name), getattr(other, name))
        for name in ("depart_s", "route_offset", "route_links")
    )


def _run(recipe: str, name: str, emissions: bool, call: int, item: Item) -> tuple[Item, Row]:
    contender, seed = item
    scenario, simulator = _parts(recipe, name, emissions, call)
    result = evaluate(
        simulator,
        contender.make(scenario.network),
        vehicles_of_seed(scenario, seed),
        make_reward(contender.reward, contender.reward_constants),
        seed,
    )
    row = measures_row(result.measures, result.memory[-1])
    row["bytes_per_intersection"] = row["bytes_total"] / len(scenario.network.intersections)
    return item, row


# One scenario serves the many runs of a comparison: what is derived from a network is kept with it.
# The number of the call keeps apart what files held at different times.
@lru_cache(maxsize=2)
def _parts(recipe: str, name: str, emissions: bool, call: int) -> tuple[Scenario, Simulator]:
    scenario = ScenarioRecipe.model_validate_json(recipe).build()
    return scenario, make_simulator(scenario, name, emissions=emissions)
