"""The study of capacity: which load each controller holds, and how it stands disturbances."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from dmil.controllers import CONTROLLERS, make_controller
from dmil.controllers.variants import Variant
from dmil.demand import DemandLevels, ScalableDemand, Vehicles
from dmil.errors import InputError
from dmil.experiments.checks import check_horizon
from dmil.experiments.trial import Row, TrialResult, columns_of, measures_row
from dmil.parallel import Executor
from dmil.rewards import Reward, make_reward
from dmil.scenarios import Scenario
from dmil.seeding import simulator_seed, stream
from dmil.simulation import DisturbedSimulator, Simulator, make_simulator
from dmil.simulation.disturbances import ClosesLanes
from dmil.statistics import queue_growth
from dmil.studies.capacity.disturbed import (
    INCIDENT,
    OTHER_DAY,
    SAME_DAY,
    SURGE,
    SURGE_S,
    begin_s,
    busy_lane,
    days_of,
    recovery_s,
    sensors_of,
)
from dmil.studies.capacity.plan import (
    CAPACITY,
    CapacityUnit,
    Place,
    contenders,
    fits,
    places,
    units,
)
from dmil.studies.capacity.search import loads_tried
from dmil.studies.capacity.settings import CapacityStudySettings
from dmil.training import Run, evaluate, run

SERIES_EVERY_S = 60
"""The course of disturbed runs is kept at this distance."""
Queue = npt.NDArray[np.int32]


@dataclass(frozen=True)
class CapacityStudy:
    """The study of capacity, as `dmil.experiments.study.run_study` runs it (ours).

    Parameters
    ----------
    settings
        What to run.
    """

    settings: CapacityStudySettings
    name: ClassVar[str] = "capacity"

    def check(self) -> None:
        """Check that networks, controllers, options and reward exist, and demand can be scaled.

        Raises
        ------
        InputError
            If there is no such network, controller, option or reward, a network's demand cannot be
            scaled, or a controller runs on no network.
        MissingExtraError
            If something needs a package that is not installed.
        """
        settings = self.settings
        made = [place.build(settings.horizon_s, settings.data)[0] for place in places(settings)]
        for each in made:
            check_horizon(each.horizon_s, each.timing.decision_interval_s)
            if not isinstance(each.demand, ScalableDemand):
                raise InputError(
                    f"the demand of '{each.name}' cannot be scaled",
                    where="networks",
                    expected="a demand of which there can be more or less",
                )
            make_simulator(each, settings.simulator)
        for variant in contenders(settings):
            make_controller(variant.name, dict(variant.options))
            if settings.controllers and not any(
                fits(variant, each, settings.simulator) for each in made
            ):
                raise InputError(
                    "it runs on none of the networks",
                    where=f"controller '{variant.label}'",
                    expected="a network with plans for those, SUMO for SUMO's, one intersection "
                    "for planners",
                )
        make_reward(settings.reward)

    def configuration(self) -> dict[str, Any]:
        """Return all settings; networks and controllers by name, files of cities left out."""
        settings = self.settings
        configuration = settings.model_dump(mode="json", exclude={"data"})
        configuration["networks"] = [place.name for place in places(settings)]
        configuration["controllers"] = [each.label for each in contenders(settings)]
        return configuration

    def plan(self) -> Sequence[CapacityUnit]:
        """Return all trials, network by network, seed by seed."""
        return units(self.settings)

    def prepare(self, folder: Path, executor: Executor) -> Callable[[CapacityUnit], TrialResult]:
        """Return what runs a unit."""
        return partial(run_unit, self.settings)


def run_unit(settings: CapacityStudySettings, unit: CapacityUnit) -> TrialResult:
    """Run a controller at all its loads, or under all disturbances; a failure becomes a row."""
    trial = _Trial(settings, unit)
    try:
        (trial.search if unit.preset == CAPACITY else trial.disturb)()
    except Exception as error:
        trial.failed(f"{type(error).__name__}: {error}")
    return TrialResult(unit, trial.runs, trial.series)


class _Trial:
    """The runs of one unit as they come."""

    def __init__(self, settings: CapacityStudySettings, unit: CapacityUnit) -> None:
        self.runs: list[Row] = []
        self.series: list[Row] = []
        self._settings, self._unit = settings, unit
        self._made, self._simulator, self._place = _at(settings, unit.scenario)
        self._levels = _levels(settings, unit.scenario, unit.seed)
        self._reward: Reward = make_reward(settings.reward)
        self._load = settings.disturbed_load * self._place.highest
        self._variant: str | None = None

    def search(self) -> None:
        """Find the highest load that stays stable; every load tried is a row."""
        settings = self._settings
        loads_tried(self._is_stable, self._place.highest, settings.levels, settings.halvings)

    def _is_stable(self, load: float) -> bool:
        self._load = load
        vehicles = self._levels.at(load)
        found = self._evaluate(self._simulator, vehicles)
        growth = queue_growth(found.measures.queued_at, len(vehicles) / self._made.horizon_s)
        self._add(found, growth=growth)
        return growth <= self._settings.tolerance

    def disturb(self) -> None:
        """Run undisturbed, then under each disturbance; the courses of those that end are kept."""
        made, seed = self._made, self._unit.seed
        days = days_of(self._levels, self._load, made.network, made.horizon_s, seed)
        plain = self._evaluate(self._simulator, days.day)
        self._add(plain)
        calm = plain.measures.queued_at
        self._keep_course(calm)
        if isinstance(self._simulator, ClosesLanes):
            closed = busy_lane(made.network, days.day, made.horizon_s, seed)
            disturbed = DisturbedSimulator(self._simulator, closed=[closed])
            self._passing(INCIDENT, disturbed, days.day, calm, closed.until_s)
        end_s = min(begin_s(made.horizon_s) + SURGE_S, made.horizon_s)
        self._passing(SURGE, self._simulator, days.surge, calm, end_s)
        for self._variant, sensors in sensors_of(made.horizon_s).items():
            disturbed = DisturbedSimulator(self._simulator, sensors=sensors)
            self._add(self._evaluate(disturbed, days.day))
        for self._variant, day in ((SAME_DAY, days.day), (OTHER_DAY, days.other)):
            self._add(self._evaluate(self._simulator, day, trained_on=days.day))

    def _passing(
        self, name: str, simulator: Simulator, vehicles: Vehicles, calm: Queue, end_s: int
    ) -> None:
        self._variant = name
        found = self._evaluate(simulator, vehicles)
        course = found.measures.queued_at
        self._add(found, recovery_s=recovery_s(course, calm, end_s))
        self._keep_course(course)

    def _evaluate(
        self, simulator: Simulator, vehicles: Vehicles, trained_on: Vehicles | None = None
    ) -> Run:
        """Run a new controller, before that on a day that it is trained on, if it learns."""
        variant, seed = self._unit.controller, self._unit.seed
        controller = make_controller(variant.name, dict(variant.options))
        if trained_on is not None and _learns(variant):
            for number in range(self._settings.training_runs):
                where = "training", "episode", number
                rng = stream(seed, *where, "exploration")
                chance = simulator_seed(seed, *where)
                run(simulator, controller, trained_on, self._reward, rng, chance)
        return evaluate(simulator, controller, vehicles, self._reward, seed)

    def _add(self, found: Run, **more: float) -> None:
        measures = measures_row(found.measures, found.memory[-1])
        self.runs.append(self._row() | measures | more | {"status": "ok"})

    def failed(self, message: str) -> None:
        """Add a row for a run that failed."""
        self.runs.append(self._row() | {"status": message})

    def _row(self) -> Row:
        trained = self._variant in (SAME_DAY, OTHER_DAY) and _learns(self._unit.controller)
        seconds = self._settings.training_runs * self._made.horizon_s
        return self._identity() | {
            "study": CapacityStudy.name,
            "trained_in": self._settings.simulator if trained else None,
            "training_s": seconds if trained else None,
            "horizon_s": self._made.horizon_s,
            "intersections": len(self._made.network.intersections),
        }

    def _identity(self) -> Row:
        return columns_of(self._unit) | {
            "load": self._load,
            "variant": self._variant,
            "embedding": None,
            "communication": False,
            "reward": self._settings.reward if _learns(self._unit.controller) else None,
            "epsilon": None,
            "simulator": self._settings.simulator,
        }

    def _keep_course(self, waiting_veh: Queue) -> None:
        identity = self._identity()
        for time_s in range(SERIES_EVERY_S, len(waiting_veh) + 1, SERIES_EVERY_S):
            row = {"time_s": time_s, "queue_veh": int(waiting_veh[time_s - 1])}
            self.series.append(identity | row)


def _learns(variant: Variant) -> bool:
    return variant.name in CONTROLLERS and CONTROLLERS[variant.name].learns


# The units of one network follow each other.
@lru_cache(maxsize=2)
def _at(settings: CapacityStudySettings, name: str) -> tuple[Scenario, Simulator, Place]:
    """Return a network's scenario, simulator and highest load."""
    place = next(each for each in places(settings) if each.scenario == name)
    made, _ = place.build(settings.horizon_s, settings.data)
    return made, make_simulator(made, settings.simulator), place


# And of these those of one seed.
@lru_cache(maxsize=2)
def _levels(settings: CapacityStudySettings, name: str, seed: int) -> DemandLevels:
    """Return the vehicles of one seed at all loads."""
    made, _, place = _at(settings, name)
    _, recorded_s = place.build(settings.horizon_s, settings.data)
    rng = stream(seed, "demand")
    return DemandLevels.draw(
        made.demand, made.network, made.horizon_s, place.highest, rng, recorded_s=recorded_s
    )
