"""``dmil evaluate``: compare controllers and policies on the same vehicles."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from dmil.cli.choices import (
    SCENARIO_OPTIONS,
    SIMULATOR_OPTIONS,
    built,
    compile_first,
    say_stand_ins,
    scenario_command,
    stopping,
    with_scenario_of,
)
from dmil.cli.controller_choice import EvaluateParameters, contenders_of, controller_options
from dmil.cli.evaluate_output import (
    COLUMN_WIDTH,
    LABEL_WIDTH,
    as_json,
    comparison_table,
    notes_of,
    ranking_table,
    unfair,
    write_seeds,
)
from dmil.cli.parameters import Option, options
from dmil.cli.terminal import print_json, progress, results, say, show, waiting
from dmil.errors import InputError
from dmil.experiments.answer import METRIC, answer, locked_notes
from dmil.experiments.comparison import Comparison, compare
from dmil.parallel import LocalExecutor
from dmil.scenarios import Scenario
from dmil.scenarios.demand_changes import DemandChanges
from dmil.scenarios.names import shown
from dmil.scenarios.recipe import ScenarioRecipe
from dmil.training import Policy, load_policy

OPTIONS = (
    *SCENARIO_OPTIONS,
    *SIMULATOR_OPTIONS,
    *controller_options(many=True),
    Option("policy", "--policy", "Controllers", "FILE", many=True),
    Option("tuned", "--tuned", "Controllers", "FILE", many=True),
    Option("baselines", "--baselines", "Controllers"),
    Option("reference", "--reference", "Controllers", "NAME"),
    *options("Test", "learn; epsilon; reward; seeds; seed; jobs"),
    *options("Output", "report FILE; csv FILE"),
)


@scenario_command("evaluate", EvaluateParameters, OPTIONS)
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
    say_stand_ins(scenario, settings.simulator, [each.variant.name for each in contenders])
    compile_first()
    seeds = range(settings.seed, settings.seed + settings.seeds)
    executor = LocalExecutor(settings.jobs)
    with stopping("no results of a comparison are kept"), progress("runs") as advance:
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
    found = replace(found.ranked(METRIC), withheld=unfair(scenario, found.labels))
    notes = notes_of(settings, found, scenario, _others(recipe, policies, settings))
    seed_text = f"{len(seeds)} seeds" if len(seeds) > 1 else f"seed {seeds[0]}"
    about: tuple[str, ...] = (
        f"{scenario.horizon_s} s",
        seed_text,
        f"simulator: {settings.simulator}",
    )
    if recipe.ignore_junction_blocker_s is not None:
        ignored = f"junction blockers ignored after {recipe.ignore_junction_blocker_s} s"
        about, seed_text = (*about, ignored), f"{seed_text}, {ignored}"
    if not json:
        show(f"{shown(scenario.name)}, {scenario.horizon_s} s, {seed_text}", "")
        _show(found, notes)
    # Last: if one cannot be written, the numbers of a long run are there all the same.
    tell = (lambda text: None) if json else say
    if settings.csv is not None:
        write_seeds(settings.csv, found)
        tell(f"Every seed: {settings.csv}")
    if settings.report is not None:
        _write_report(settings.report, recipe, scenario, found, about, notes)
        tell(f"Report: {settings.report}")
    if json:
        files = {"report": settings.report, "csv": settings.csv}
        print_json(as_json(found, scenario, notes) | files)


def _show(found: Comparison, notes: list[str]) -> None:
    for text in (found.withheld, answer(found), *locked_notes(found)):
        if text:
            show(text, "")
    show(ranking_table(found, METRIC), "")
    # As many controllers side by side as the terminal is wide.
    fitting = max(1, (results().width - LABEL_WIDTH) // (COLUMN_WIDTH + 1))
    for first in range(0, len(found.labels), fitting):
        show(comparison_table(found, range(len(found.labels))[first : first + fitting]), "")
    show(*notes)


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
