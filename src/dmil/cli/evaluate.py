"""``dmil evaluate``: compare controllers and policies on the same vehicles."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import typer
from pydantic import Field, field_validator

from dmil.cli.application import StoppedError
from dmil.cli.building import built, say_stand_ins
from dmil.cli.choices import (
    SCENARIO_OPTIONS,
    SIMULATOR_OPTIONS,
    ControllerChoice,
    RewardChoice,
    SimulatorChoice,
    complete_scenario,
    controller_options,
    files_as_settings,
    with_scenario_of,
)
from dmil.cli.contenders import contenders_of
from dmil.cli.evaluate_output import as_json, notes_of, write_seeds
from dmil.cli.evaluate_table import (
    COLUMN_WIDTH,
    LABEL_WIDTH,
    comparison_table,
    ranking_table,
)
from dmil.cli.fairness import unfair
from dmil.cli.help import Command
from dmil.cli.parameters import Option, settings_command
from dmil.cli.terminal import print_json, progress, results, say, show, waiting
from dmil.compilation import is_cold
from dmil.errors import InputError
from dmil.experiments.answer import METRIC, answer, locked_notes
from dmil.experiments.comparison import Comparison, compare
from dmil.experiments.warm_up import compile_kernels
from dmil.parallel import LocalExecutor
from dmil.scenarios import Scenario
from dmil.scenarios.demand_changes import DemandChanges
from dmil.scenarios.names import shown
from dmil.scenarios.recipe import ScenarioRecipe
from dmil.seeding import LARGEST_SEED
from dmil.training import Policy, load_policy


class EvaluateParameters(ScenarioRecipe, SimulatorChoice, RewardChoice):
    """A comparison."""

    controller: tuple[ControllerChoice, ...] = Field(
        (), description="Controller to evaluate; may be repeated."
    )
    policy: tuple[Path, ...] = Field((), description="Policy to evaluate; may be repeated.")
    tuned: tuple[Path, ...] = Field(
        (), description="Controller to evaluate with the options from dmil tune; may be repeated."
    )
    changes: dict[str, Any] = Field(
        {}, description="Settings that override those of all evaluated controllers and policies."
    )
    seeds: int = Field(10, ge=1, description="Number of test seeds.")
    seed: int = Field(0, ge=0, le=LARGEST_SEED, description="First seed.")
    baselines: bool = Field(
        True,
        description="Add the network's own plan, actuated control (in SUMO), longest-queue-first "
        "and max-pressure with approaching vehicles, factored and lookahead; on grids "
        "fixed-cycle, longest-queue-first and max-pressure.",
    )
    reference: str | None = Field(
        None,
        description="Reference for paired differences: a controller, added if missing, or the "
        "file name of a policy; by default the network's own plan, or max-pressure.",
    )
    learn: bool = Field(
        False, description="Let learners keep learning and exploring during the test."
    )
    epsilon: float | None = Field(
        None,
        ge=0,
        le=1,
        description="Probability of a random action; by default 0 when frozen, else the learner's "
        "own.",
    )
    report: Path | None = Field(
        None, description="Write the comparison as a page (.html) with a map of the network."
    )
    csv: Path | None = Field(None, description="Write the values of every seed, one row per run.")
    jobs: int | None = Field(
        None,
        ge=1,
        description="Parallel processes; by default one per core. Results do not change.",
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
    Option("csv", "--csv", "Output", "FILE"),
)

app = typer.Typer(add_completion=False)


def _complete(settings: EvaluateParameters) -> EvaluateParameters:
    controllers = tuple(choice.complete() for choice in settings.controller)
    changes = complete_scenario(settings) | {"controller": controllers}
    return settings.model_copy(update=changes)


@app.command(cls=Command)
@settings_command(
    "evaluate", EvaluateParameters, OPTIONS, complete=_complete, files=files_as_settings
)
def evaluate(settings: EvaluateParameters, json: bool) -> None:
    """Compare controllers and trained policies on the same vehicles.

    For example:
        dmil evaluate city.sumocfg --simulator sumo --report report.html
        dmil evaluate city.sumocfg --resample --seeds 20 --csv seeds.csv
        dmil evaluate --policy policy.npz
        dmil evaluate --scenario grid:5x5 --controller random --seeds 30
        dmil evaluate --policy a.npz --policy b.npz --scenario grid:3x3 --load 1.5
        dmil evaluate --scenario grid:3x3 --controller max-pressure,approaching=true
        dmil evaluate --scenario grid:3x3 --controller mine:MyController

    In each seed all controllers meet the same vehicles. The recommendation comes first, then
    delays: mean, median, interquartile mean (IQM) and worst seed, and the paired difference from
    --reference with its 95 % bootstrap interval: wholly below 0 means less than the reference.
    "program" is the network's own plan. Travel time runs from departure to arrival, delay is the
    part lost against free flow, W the part spent in queues, all in s per vehicle. Recorded vehicles
    are one day, the same in every seed: --resample draws similar days.

    Policies and learning controllers are frozen by default: they do not learn and always take the
    action with the highest value (ε = 0). The seeds then show how good the learned policy is.
    Factored and lookahead memory need no training: they learn from the first second.
    """
    judged = settings.policy or settings.controller or settings.tuned
    if not judged and not settings.baselines:
        raise InputError(
            "nothing to evaluate", where="evaluate", mend="add --controller or --policy"
        )
    policies = [load_policy(path) for path in settings.policy]
    recipe = with_scenario_of(settings, policies[0] if policies else None)
    scenario = built(recipe)
    contenders, reference = contenders_of(settings, policies, scenario)
    say_stand_ins(scenario, settings.simulator, [each.controller for each in contenders])
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
                reference=reference,
                executor=executor,
                progress=advance,
            )
    except KeyboardInterrupt:
        raise StoppedError("no results of a comparison are kept") from None
    found = replace(found.ranked(METRIC), withheld=unfair(scenario, found.labels))
    notes = notes_of(settings, found, scenario, _others(recipe, policies, settings))
    seed_text = f"{len(seeds)} seeds" if len(seeds) > 1 else f"seed {seeds[0]}"
    about = (f"{scenario.horizon_s} s", seed_text, f"simulator: {settings.simulator}")
    if json:
        if settings.csv is not None:
            write_seeds(settings.csv, found)
        if settings.report is not None:
            _write_report(settings.report, recipe, scenario, found, about, notes)
        files = {"report": settings.report, "csv": settings.csv}
        print_json(as_json(found, scenario, notes) | files)
        return
    show(f"{shown(scenario.name)}, {scenario.horizon_s} s, {seed_text}", "")
    if found.withheld:
        show(found.withheld, "")
    show(answer(found), "")
    for note in locked_notes(found):
        show(note, "")
    show(ranking_table(found, METRIC), "")
    # As many controllers side by side as the terminal is wide.
    fitting = max(1, (results().width - LABEL_WIDTH) // (COLUMN_WIDTH + 1))
    for first in range(0, len(found.labels), fitting):
        show(comparison_table(found, range(len(found.labels))[first : first + fitting]), "")
    for note in notes:
        show(note)
    # Last: if one cannot be written, the numbers of a long run are there all the same.
    if settings.csv is not None:
        write_seeds(settings.csv, found)
        say(f"Every seed: {settings.csv}")
    if settings.report is not None:
        _write_report(settings.report, recipe, scenario, found, about, notes)
        say(f"Report: {settings.report}")


def _others(
    recipe: ScenarioRecipe, policies: list[Policy], settings: EvaluateParameters
) -> list[str]:
    """Name the policies that were trained on other networks or demand than evaluated here."""
    ours = recipe.model_dump(mode="json", exclude_none=True)
    found = []
    for path, policy in zip(settings.policy, policies, strict=True):
        theirs = policy.training.get("recipe")
        if theirs is None:
            continue
        trained = ScenarioRecipe(**theirs).model_dump(mode="json", exclude_none=True)
        differs = [key for key in {**ours, **trained} if ours.get(key) != trained.get(key)]
        if differs:
            found.append(f"{path.name} (differs in {', '.join(differs)})")
    return found


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

    files = (recipe.roadnet, recipe.flow, recipe.net, *recipe.routes, *recipe.additional)
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
        case = replace(case, timing=scenario.timing)
        write_comparison(
            path, found, examine(case), title=shown(scenario.name), about=about, notes=notes
        )
