"""``dmil evaluate``: controllers and policies side by side, on the same vehicles."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import typer
from pydantic import Field, field_validator

from dmil.cli.application import StoppedError
from dmil.cli.choices import (
    SCENARIO_OPTIONS,
    SIMULATOR_OPTIONS,
    ControllerChoice,
    RewardChoice,
    SimulatorChoice,
    built,
    complete_scenario,
    controller_options,
    with_scenario_of,
)
from dmil.cli.contenders import contenders_of
from dmil.cli.evaluate_table import COLUMN_WIDTH, DIFFERENCES, LABEL_WIDTH, comparison_table
from dmil.cli.help import Command
from dmil.cli.measures import UNFINISHED
from dmil.cli.parameters import Option, settings_command
from dmil.cli.terminal import print_json, progress, results, say, show, waiting
from dmil.compilation import is_cold
from dmil.controllers import CONTROLLERS
from dmil.demand import CityflowDemand, SumoDemand
from dmil.errors import InputError
from dmil.scenarios import Scenario
from dmil.scenarios.demand_changes import DemandChanges
from dmil.scenarios.recipe import ScenarioRecipe
from dmil.seeding import LARGEST_SEED
from dmil.statistics import Estimate
from dmil.studies import LocalExecutor, compile_kernels
from dmil.studies.comparison import REFERENCE, Comparison, compare
from dmil.training import load_policy

UNDRIVABLE = ("unknown-road", "no-way", "one-road")


class EvaluateParameters(ScenarioRecipe, SimulatorChoice, RewardChoice):
    """A comparison."""

    controller: tuple[ControllerChoice, ...] = Field(
        (), description="Controller to judge; may be repeated."
    )
    policy: tuple[Path, ...] = Field((), description="Policy to judge; may be repeated.")
    tuned: tuple[Path, ...] = Field(
        (), description="Controller to judge with what dmil tune chose for it; may be repeated."
    )
    changes: dict[str, Any] = Field(
        {}, description="Settings that go over those of all judged controllers and policies."
    )
    seeds: int = Field(10, ge=1, description="Number of test seeds.")
    seed: int = Field(0, ge=0, le=LARGEST_SEED, description="First of the seeds.")
    baselines: bool = Field(
        True, description="Put fixed-cycle, longest-queue-first and max-pressure beside."
    )
    reference: str = Field(
        REFERENCE,
        description="Whom differences are taken to: a controller, put beside if it is not yet, or "
        "the file name of a policy.",
    )
    learn: bool = Field(
        False, description="Let learners go on learning and exploring during the test."
    )
    epsilon: float | None = Field(
        None,
        ge=0,
        le=1,
        description="Chance of a random action; by default 0 when frozen, else the learner's own.",
    )
    report: Path | None = Field(
        None, description="Write the comparison as a page (.html) with a picture of the network."
    )
    jobs: int | None = Field(
        None, ge=1, description="Parallel processes; by default one per core. Same results."
    )

    @field_validator("controller", mode="before")
    @classmethod
    def _several(cls, value: Any) -> Any:
        return value if isinstance(value, list | tuple) else [value]


OPTIONS = (
    *SCENARIO_OPTIONS,
    *SIMULATOR_OPTIONS,
    *controller_options(many=True),
    Option("policy", "--policy", "Controllers", "FILE", many=True),
    Option("tuned", "--tuned", "Controllers", "FILE", many=True),
    Option("baselines", "--baselines", "Controllers"),
    Option("reference", "--reference", "Controllers", "NAME"),
    Option("learn", "--learn", "Test"),
    Option("epsilon", "--epsilon", "Test"),
    Option("reward", "--reward", "Test"),
    Option("seeds", "--seeds", "Test"),
    Option("seed", "--seed", "Test"),
    Option("jobs", "--jobs", "Test"),
    Option("report", "--report", "Output", "FILE"),
)

app = typer.Typer(add_completion=False)


def _complete(settings: EvaluateParameters) -> EvaluateParameters:
    controllers = tuple(choice.complete() for choice in settings.controller)
    changes = complete_scenario(settings) | {"controller": controllers}
    return settings.model_copy(update=changes)


@app.command(cls=Command)
@settings_command("evaluate", EvaluateParameters, OPTIONS, complete=_complete)
def evaluate(settings: EvaluateParameters, json: bool) -> None:
    """Compare controllers and trained policies on the same vehicles.

    For example:
        dmil evaluate --policy policy.npz
        dmil evaluate --scenario grid:5x5 --controller random --seeds 30
        dmil evaluate --policy a.npz --policy b.npz --scenario grid:3x3 --load 1.5
        dmil evaluate --scenario grid:3x3 --controller max-pressure,approaching=true
        dmil evaluate --scenario grid:3x3 --controller mine:MyController
        dmil evaluate --policy policy.npz --simulator sumo --reference program

    In each seed all controllers meet the same vehicles. The table shows means over seeds with 95 %
    bootstrap intervals, and the paired difference to --reference, which is max-pressure unless
    another is named: an interval wholly below 0 means less than the reference needs. "program" is
    the network's own plan. Travel time runs from departure to arrival, delay is what of it was lost
    against driving freely, W is the part spent in queues, all in s per vehicle.

    A policy, or a controller that learns, is frozen by default: it does not learn, and always takes
    the action it holds best (ε = 0). Then the seeds tell how good what it has learned is.
    """
    judged = settings.policy or settings.controller or settings.tuned
    if not judged and not settings.baselines:
        raise InputError("nobody to judge", where="evaluate", mend="add --controller or --policy")
    policies = [load_policy(path) for path in settings.policy]
    recipe = with_scenario_of(settings, policies[0] if policies else None)
    scenario = built(recipe)
    contenders = contenders_of(settings, policies)
    if is_cold():
        with waiting("First start: compiling kernels, once …"):
            compile_kernels()
    seeds = range(settings.seed, settings.seed + settings.seeds)
    executor = LocalExecutor(settings.jobs)
    try:
        with progress("runs") as advance:
            found = compare(
                recipe,
                contenders,
                seeds,
                simulator=settings.simulator,
                emissions=settings.emissions,
                reference=settings.reference,
                executor=executor,
                progress=advance,
            )
    except KeyboardInterrupt:
        raise StoppedError("nothing is kept of a comparison") from None
    notes = _notes(settings, found, scenario)
    seed_text = f"{len(seeds)} seeds" if len(seeds) > 1 else f"seed {seeds[0]}"
    about = (f"{scenario.horizon_s} s", seed_text, f"simulator: {settings.simulator}")
    if json:
        if settings.report is not None:
            _write_report(settings.report, recipe, scenario, found, about, notes)
        print_json(_as_json(found, scenario, notes) | {"report": settings.report})
        return
    show(f"{scenario.name}, {scenario.horizon_s} s, {seed_text}", "")
    # As many controllers side by side as the terminal is wide.
    fitting = max(1, (results().width - LABEL_WIDTH) // (COLUMN_WIDTH + 1))
    for first in range(0, len(found.labels), fitting):
        show(comparison_table(found, range(len(found.labels))[first : first + fitting]), "")
    for note in notes:
        show(note)
    if settings.report is not None:
        # Last: if it cannot be written, the numbers of a long run are there all the same.
        _write_report(settings.report, recipe, scenario, found, about, notes)
        say(f"Report: {settings.report}")


def _write_report(
    path: Path,
    recipe: ScenarioRecipe,
    scenario: Scenario,
    found: Comparison,
    about: tuple[str, ...],
    notes: list[str],
) -> None:
    from dmil.doctor import examine, read_case
    from dmil.reports.comparison_page import write_comparison

    files = (recipe.roadnet, recipe.flow, recipe.net, *recipe.routes)
    with waiting("writing the report"):
        case = read_case(
            [recipe.scenario] if recipe.scenario else [str(file) for file in files if file],
            begin_s=recipe.begin_s,
            horizon_s=recipe.horizon_s,
            phases=recipe.phases,
            routing=recipe.routing,
        )
        if recipe.demand != DemandChanges() or recipe.ties is not None:
            case = replace(case, demand=scenario.demand)
        write_comparison(path, found, examine(case), title=scenario.name, about=about, notes=notes)


def _notes(settings: EvaluateParameters, found: Comparison, scenario: Scenario) -> list[str]:
    notes = [UNFINISHED]
    several = len(found.seeds) > 1
    if several:
        notes.append("Below each mean: its 95 % bootstrap interval over seeds.")
    if found.same_demand:
        differs = (
            "only chance inside the controllers differs, so the interval of one that draws nothing "
            "is exact."
            if found.exact
            else "seeds differ by SUMO's drivers and by chance inside the controllers."
        )
        notes.append(f"The vehicles are recorded, the same in every seed: {differs}")
        left_out = _left_out(scenario)
        if left_out:
            notes.append(
                f"Left out, since they cannot be driven: {left_out} of the files' vehicles; "
                "dmil doctor says which."
            )
    elif several:
        notes.append("Each seed has vehicles of its own, the same for all controllers.")
    entries = [CONTROLLERS.get(choice.name) for choice in settings.controller]
    online = [
        choice.label
        for choice, entry in zip(settings.controller, entries, strict=True)
        if entry and entry.online and choice.options.get("learning", True)
    ]
    if online:
        notes.append(f"Learning from the first second, untrained: {', '.join(online)}.")
    if settings.policy or any(entry and entry.learns and not entry.online for entry in entries):
        epsilon = "their own" if settings.epsilon is None else f"{settings.epsilon:g}"
        frozen = f"frozen, ε = {settings.epsilon or 0:g}"
        notes.append(f"Learners: {f'learning, ε = {epsilon}' if settings.learn else frozen}.")
    timing = scenario.timing
    notes.append(
        f"Decisions every {timing.decision_interval_s} s, clearance {timing.clearance_s} s, "
        f"minimum green {timing.min_green_s} s."
    )
    return notes


def _left_out(scenario: Scenario) -> int:
    """Return how many vehicles the files have that this network has no way for."""
    demand = scenario.demand
    remarks = demand.remarks if isinstance(demand, SumoDemand | CityflowDemand) else ()
    return sum(each.count for each in remarks if each.kind in UNDRIVABLE)


def _as_json(found: Comparison, scenario: Scenario, notes: list[str]) -> dict[str, Any]:
    means = {name: found.mean(name) for name in found.measures}
    differences = {name: found.difference(name) for name in DIFFERENCES}
    return {
        "scenario": scenario.name,
        "horizon_s": scenario.horizon_s,
        "seeds": list(found.seeds),
        "same_demand": found.same_demand,
        "controllers": [
            {
                "controller": label,
                "measures": {name: _ends(each, i) for name, each in means.items()},
                f"minus_{found.reference}": {
                    name: _ends(each, i) for name, each in differences.items() if each is not None
                },
                "per_seed": {
                    name: values[:, i].tolist() for name, values in found.measures.items()
                },
            }
            for i, label in enumerate(found.labels)
        ],
        "notes": notes,
    }


def _ends(estimate: Estimate, i: int) -> dict[str, float]:
    return {"mean": estimate.value[i], "low": estimate.low[i], "high": estimate.high[i]}
