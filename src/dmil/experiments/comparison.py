"""Compare controllers on one scenario: the same vehicles for all in each seed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from itertools import count

import numpy as np
import numpy.typing as npt

from dmil.experiments.contender import Contender
from dmil.experiments.study import Kept, Progress, run_trials
from dmil.experiments.trial import Row, run_row
from dmil.network import RoadNetwork
from dmil.parallel import Executor
from dmil.results.metrics import METRICS
from dmil.rewards import make_reward
from dmil.scenarios import Scenario
from dmil.scenarios.recipe import ScenarioRecipe
from dmil.seeding import stream
from dmil.simulation import Simulator, make_simulator
from dmil.statistics import Estimate, interquartile_mean, mean_interval, paired_difference
from dmil.training import evaluate, vehicles_of_seed
from dmil.training.flow import Flow, FlowRecorder, locks

REFERENCE = "max-pressure"
"""Default reference for paired differences."""


Item = tuple[Contender, int]
Result = tuple[Item, Row, Flow]
CALLS = count()
"""Numbers of comparisons and tunings, see `place_of`."""


@dataclass(frozen=True, slots=True)
class Locked:
    """An intersection, by its id, that stood still from a second on, see `locks`."""

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
        """Return the paired difference to the reference, or to another label; None without."""
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
    progress: Progress | None = None,
) -> Comparison:
    """Run every contender in every seed, on the same vehicles in a seed.

    Every run begins with what the contender had learned before, so seeds are independent. Runs
    happen in processes of this machine by default. ``progress`` is called with the number of
    finished runs and of all; for the simulator see `dmil.simulation.make_simulator`.
    """
    made = recipe.build()
    for contender in contenders:
        contender.make(made.network)  # what is wrong with one shall show before the first run
    items = [(contender, seed) for contender in contenders for seed in seeds]
    run = partial(_run, recipe.model_dump_json(), simulator, emissions, next(CALLS))
    found = Kept()
    run_trials(items, found, lambda _: run, executor=executor, progress=progress)
    rows = [found[item][1] for item in items]
    flows = {item: flow for item, _, flow in found.values()}
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


def _run(recipe: str, name: str, emissions: bool, call: int, item: Item) -> Result:
    contender, seed = item
    scenario, simulator = place_of(recipe, name, call, emissions=emissions)
    recorder = FlowRecorder()
    result = evaluate(
        simulator,
        contender.make(scenario.network),
        vehicles_of_seed(scenario, seed),
        make_reward(contender.reward, contender.reward_constants),
        seed,
        observers=[recorder],
    )
    return item, run_row(result, scenario.network), recorder.flow


@lru_cache(maxsize=2)
def place_of(
    recipe: str, name: str, call: int, *, emissions: bool = False
) -> tuple[Scenario, Simulator]:
    """Return scenario and simulator for many runs: what is derived from a network is kept with it.

    The recipe is JSON; the number of the comparison or tuning is there because files may change
    between two.
    """
    scenario = ScenarioRecipe.model_validate_json(recipe).build()
    return scenario, make_simulator(scenario, name, emissions=emissions)
