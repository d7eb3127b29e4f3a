"""Compare controllers on one scenario: the same vehicles for all in each seed."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from itertools import count
from pathlib import Path

import numpy as np
import numpy.typing as npt

from dmil.controllers import Controller, make_controller
from dmil.experiments.trial import Row, measures_row
from dmil.network import RoadNetwork
from dmil.parallel.executors import Executor, LocalExecutor
from dmil.results.metrics import METRICS
from dmil.rewards import PAPER_CONSTANTS, RewardConstants, make_reward
from dmil.scenarios import Scenario
from dmil.scenarios.recipe import ScenarioRecipe
from dmil.seeding import stream
from dmil.simulation import Simulator, make_simulator
from dmil.statistics import Estimate, interquartile_mean, mean_interval, paired_difference
from dmil.training import controller_of, evaluate, load_policy, vehicles_of_seed
from dmil.training.flow import Flow, FlowRecorder, locks

REFERENCE = "max-pressure"
"""Whom differences are taken to, unless another is named."""


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
        """Make the controller for a network, with what it has learned."""
        options = json.loads(self.options)
        if self.policy is None:
            return make_controller(self.controller, options)
        return controller_of(load_policy(Path(self.policy)), network, where=self.policy, **options)


Item = tuple[Contender, int]
_CALLS = count()


@dataclass(frozen=True, slots=True)
class Locked:
    """A junction that stood still until the end of a run, see `dmil.training.flow.locks`.

    Attributes
    ----------
    junction: str
        Id of the intersection.
    since_s: int
        From this second on.
    """

    junction: str
    since_s: int


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
        Whether the vehicles are the same in every seed: one recorded day.
    exact: bool
        Whether the simulator itself draws nothing.
    reference: str
        Label of the contender that differences are taken to.
    locked: dict
        (label, seed) to the junctions that locked in that run, the first to lock first; runs
        without such are missing.
    withheld: str
        Why no differences are taken; empty if they are.
    """

    labels: list[str]
    seeds: range
    measures: dict[str, npt.NDArray[np.float64]]
    same_demand: bool
    exact: bool = True
    reference: str = REFERENCE
    locked: dict[tuple[str, int], tuple[Locked, ...]] = field(default_factory=dict)
    withheld: str = ""

    @property
    def one_day(self) -> bool:
        """Whether seeds change nothing on the roads, so that there is nothing to be sure of."""
        return self.same_demand and self.exact

    def mean(self, measure: str) -> Estimate:
        """Return the mean over seeds, for every contender.

        Its interval is NaN where there is one day only.
        """
        values = self.measures[measure]
        estimate = mean_interval(values, stream(0, "bootstrap", "comparison", measure))
        return self._of_this_day(estimate)

    def difference(self, measure: str, reference: str | None = None) -> Estimate | None:
        """Return the paired difference to a reference, None if there is none.

        Parameters
        ----------
        measure
            Of what.
        reference
            Label of another contender than the comparison's own reference.
        """
        label = reference or self.reference
        if self.withheld or label not in self.labels:
            return None
        values = self.measures[measure]
        estimate = paired_difference(
            values,
            values[:, [self.labels.index(label)]],
            stream(0, "bootstrap", "comparison", measure),
        )
        return self._of_this_day(estimate)

    def spread(self, measure: str) -> dict[str, npt.NDArray[np.float64]]:
        """Return median, interquartile mean and worst seed, (contenders,) each."""
        values = self.measures[measure]
        worst = np.min if METRICS[measure].better == "more" else np.max
        return {
            "median": np.median(values, axis=0),
            "interquartile_mean": interquartile_mean(values.T),
            "worst": worst(values, axis=0),
        }

    def ranked(self, measure: str) -> Comparison:
        """Return the same with the contenders sorted, the least mean first."""
        order = np.argsort(self.measures[measure].mean(axis=0), kind="stable")
        return replace(
            self,
            labels=[self.labels[i] for i in order],
            measures={name: values[:, order] for name, values in self.measures.items()},
        )

    def _of_this_day(self, estimate: Estimate) -> Estimate:
        if not self.one_day:
            return estimate
        nothing = np.full_like(estimate.value, np.nan)
        return Estimate(estimate.value, nothing, nothing, estimate.seeds)


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
    """Run every contender in every seed, on the same vehicles in a seed.

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
    flows: dict[Item, Flow] = {}
    done = 0
    if progress:
        progress(done, len(items))
    run = partial(_run, recipe.model_dump_json(), simulator, emissions, next(_CALLS))
    for item, row, flow in (executor or LocalExecutor()).map(run, items):
        rows[place[item]], flows[item] = row, flow
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
        locked=_locked(made.network, contenders, seeds, flows),
    )


def _locked(
    network: RoadNetwork, contenders: Sequence[Contender], seeds: range, flows: dict[Item, Flow]
) -> dict[tuple[str, int], tuple[Locked, ...]]:
    ids = [item.id for item in network.intersections]
    return {
        (contender.label, seed): tuple(Locked(ids[each.intersection], each.since_s) for each in one)
        for seed in seeds
        for contender, one in zip(
            contenders, locks([flows[contender, seed] for contender in contenders]), strict=True
        )
        if one
    }


def has_same_demand(scenario: Scenario, seed: int) -> bool:
    """Tell whether the vehicles are the same in every seed, as recorded ones are."""
    one, other = vehicles_of_seed(scenario, seed), vehicles_of_seed(scenario, seed + 1)
    return all(
        np.array_equal(getattr(one, name), getattr(other, name))
        for name in ("depart_s", "route_offset", "route_links")
    )


def _run(recipe: str, name: str, emissions: bool, call: int, item: Item) -> tuple[Item, Row, Flow]:
    contender, seed = item
    scenario, simulator = _parts(recipe, name, emissions, call)
    recorder = FlowRecorder()
    result = evaluate(
        simulator,
        contender.make(scenario.network),
        vehicles_of_seed(scenario, seed),
        make_reward(contender.reward, contender.reward_constants),
        seed,
        observers=[recorder],
    )
    row = measures_row(result.measures, result.memory[-1])
    row["bytes_per_intersection"] = row["bytes_total"] / len(scenario.network.intersections)
    return item, row, recorder.flow


# One scenario serves the many runs of a comparison: what is derived from a network is kept with it.
# The number of the call keeps apart what files held at different times.
@lru_cache(maxsize=2)
def _parts(recipe: str, name: str, emissions: bool, call: int) -> tuple[Scenario, Simulator]:
    scenario = ScenarioRecipe.model_validate_json(recipe).build()
    return scenario, make_simulator(scenario, name, emissions=emissions)
