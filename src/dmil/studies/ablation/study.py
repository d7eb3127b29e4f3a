"""The ablation: each part of our controllers switched off or on alone, on the same vehicles."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, ClassVar

from dmil.controllers import make_controller
from dmil.experiments.cells import Cell
from dmil.experiments.checks import check_horizon
from dmil.experiments.trial import SIMULATOR, Row, TrialResult, measures_row
from dmil.parallel import Executor
from dmil.rewards import make_reward
from dmil.scenarios import Scenario
from dmil.scenarios.names import PREFIX, kind_of
from dmil.simulation import Simulator, make_simulator
from dmil.simulation.sumo.process import require_sumo
from dmil.studies.ablation.plan import AblationUnit, cells, units, variants
from dmil.studies.ablation.settings import AblationStudySettings
from dmil.training import evaluate, vehicles_of_seed
from dmil.training.flow import FlowRecorder, locks_of

REWARD = "queue"
"""Memories of lanes learn from the vehicles that they see, whatever the reward is."""


@dataclass(frozen=True)
class AblationStudy:
    """The ablation, as `dmil.experiments.study.run_study` runs it (ours).

    Parameters
    ----------
    settings
        What to run.
    """

    settings: AblationStudySettings
    name: ClassVar[str] = "ablation"

    def check(self) -> None:
        """Check that cells, controllers and parts exist, and that runs are long enough.

        Raises
        ------
        InputError
            If there is no such cell, controller or part, or a run is too short.
        MissingExtraError
            If a cell needs SUMO and it is not installed.
        """
        settings = self.settings
        for each in variants(settings):
            make_controller(each.name, each.options)
        if any(simulator_of(cell) != SIMULATOR for cell in cells(settings)):
            require_sumo()
        for cell in cells(settings):
            made = cell.build(settings.horizon_s, settings.data)
            check_horizon(made.horizon_s, made.timing.decision_interval_s)

    def configuration(self) -> dict[str, Any]:
        """Return all settings; what runs by its labels, files of cities left out."""
        settings = self.settings
        configuration = settings.model_dump(mode="json", exclude={"data", "parts"})
        configuration["variants"] = [each.label for each in variants(settings)]
        return configuration

    def plan(self) -> list[AblationUnit]:
        """Return one trial for each cell and seed."""
        return units(self.settings)

    def prepare(self, folder: Path, executor: Executor) -> Callable[[AblationUnit], TrialResult]:
        """Return what runs one trial."""
        return partial(run_unit, self.settings)


def simulator_of(cell: Cell) -> str:
    """Return the simulator that a cell runs in: SUMO where its roads are SUMO's."""
    in_sumo = cell.scenario.startswith(PREFIX) or kind_of(cell.scenario)[0] == "sumo"
    return "sumo" if in_sumo else SIMULATOR


def run_unit(settings: AblationStudySettings, unit: AblationUnit) -> TrialResult:
    """Run all variants on the same vehicles; a run that fails becomes a row that says so (ours)."""
    made, simulator = _place(unit.cell, settings.horizon_s, settings.data)
    vehicles = vehicles_of_seed(made, unit.seed)
    result = TrialResult(unit, [], [])
    for variant in variants(settings):
        row: Row = asdict(unit) | {
            "study": "ablation",
            "controller": variant.label,
            "communication": False,
            "simulator": simulator_of(unit.cell),
            "horizon_s": made.horizon_s,
            "intersections": len(made.network.intersections),
        }
        result.runs.append(row)
        recorder = FlowRecorder()
        try:
            controller = make_controller(variant.name, variant.options)
            run = evaluate(
                simulator,
                controller,
                vehicles,
                make_reward(REWARD),
                unit.seed,
                observers=[recorder],
            )
        except Exception as error:
            row["status"] = f"{type(error).__name__}: {error}"
            continue
        locked = locks_of(recorder.flow, made.network, vehicles)
        row |= measures_row(run.measures, run.memory[-1]) | {"status": "ok"}
        row |= {"locked": len(locked), "locked_from_s": locked[0].since_s if locked else None}
    return result


@lru_cache(maxsize=2)
def _place(cell: Cell, horizon_s: int, data: Path | None) -> tuple[Scenario, Simulator]:
    """Return a cell's scenario and simulator; the last ones stay, with all derived from them."""
    made = cell.build(horizon_s, data)
    return made, make_simulator(made, simulator_of(cell))
