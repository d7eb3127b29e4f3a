"""``dmil tune``: options of controllers, chosen on tuning seeds with the same budget for each."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import Field

from dmil.cli.choices import (
    SCENARIO_OPTIONS,
    SIMULATOR_OPTIONS,
    RewardChoice,
    SimulatorChoice,
    built,
    compile_first,
    complete_scenario,
    recipe_of,
    scenario_command,
    stopping,
)
from dmil.cli.controller_choice import Controllers, controller_options
from dmil.cli.parameters import JOBS, Option, options, part_of
from dmil.cli.terminal import number, print_json, progress, say, show
from dmil.controllers.variants import Variant
from dmil.errors import InputError
from dmil.experiments.tuning import Tuned, TuningSettings, check_tuning, planned_tuning
from dmil.experiments.tuning import tune as tune_one
from dmil.experiments.tuning.record import ENDING
from dmil.parallel import LocalExecutor
from dmil.scenarios.recipe import ScenarioRecipe

UNITS = {
    "delay_s": "delay in s per vehicle",
    "travel_time_s": "travel time in s per vehicle",
    "wait_per_spawned_s": "W in s per vehicle",
    "mean_queue_veh": "mean queue in veh",
}


class TuneParameters(ScenarioRecipe, SimulatorChoice, RewardChoice, TuningSettings):
    """A tuning of some controllers."""

    controller: Controllers = Field(
        (), description="Controller to tune; may be repeated. Options given with it stay fixed."
    )
    changes: dict[str, Any] = Field({}, description="Options to keep fixed for all controllers.")
    out: Path = Field(
        Path("tuned"),
        description="Folder for one file per controller; tunings started there are resumed.",
    )
    jobs: int | None = JOBS


OPTIONS = (
    *SCENARIO_OPTIONS,
    SIMULATOR_OPTIONS[0],
    *controller_options(many=True),
    *options(
        "Tuning",
        "budget; seeds; check_seeds; episodes; frozen; metric; reward; seed; jobs",
    ),
    Option("out", "--out", "Output", "FOLDER"),
)


@scenario_command("tune", TuneParameters, OPTIONS, complete_scenario)
def tune(settings: TuneParameters, json: bool) -> None:
    """Tune options of controllers on tuning seeds, with the same budget for each.

    For example:
        dmil tune --scenario grid:3x3 --controller sarsa --controller dual-memory
        dmil tune --scenario grid:3x3 --controller dual-memory,embedding=cells --budget 5000
        dmil train --tuned tuned/sarsa.json --scenario grid:3x3 --out policy.npz
        dmil evaluate --tuned tuned/longest-queue-first.json --scenario grid:3x3

    Candidates start on a ninth of the tuning seeds; about one in three advances to three times as
    many (successive halving). The best one is compared with the defaults on further tuning seeds
    and chosen only if it is better there as well. No command accepts a tuning seed as its --seed,
    so tuning never sees the vehicles or random numbers of a test.

    The budget counts runs of the scenario's length, training included. Every score is kept: after
    Ctrl-C repeat the command to continue.
    """
    chosen = (
        Variant(choice.name, choice.options | settings.changes) for choice in settings.controller
    )
    variants = {variant.label: variant for variant in chosen}
    if not variants:
        raise InputError("nothing to tune", where="tune", mend="add --controller NAME")
    recipe = recipe_of(settings)
    built(recipe)  # what is wrong with the files is said before hours of work, and what is left out
    compile_first()
    found: list[tuple[Path, Tuned]] = []
    # What is wrong with the last one shows before the first one has run for hours.
    plans = []
    for label, variant in variants.items():
        plan = planned_tuning(
            recipe,
            variant,
            part_of(settings, TuningSettings),
            simulator=settings.simulator,
            reward=settings.reward,
            reward_constants=settings.reward_constants,
        )
        plans.append((plan, settings.out / f"{label}{ENDING}"))
        check_tuning(*plans[-1])
    kept = f"all scores are kept in {settings.out}; repeat the command to continue"
    with stopping(kept), LocalExecutor(settings.jobs) as executor:
        for plan, path in plans:
            with progress(f"runs of {plan.label}") as advance:
                tuned = tune_one(plan, path, executor=executor, progress=advance)
            found.append((path, tuned))
            if not json:
                show(*_lines(tuned, path), "")
    if found[0][1].same_demand:
        say(
            "The vehicles are recorded, the same in every seed: a test on this scenario uses the "
            "tuning vehicles. Evaluate on another one."
        )
    if json:
        print_json({"tuned": [{"file": path} | tuned.summary() for path, tuned in found]})


def _lines(tuned: Tuned, path: Path) -> list[str]:
    """Return what a tuning found, as text."""
    told = tuned.summary()
    head = f"{tuned.label} on {tuned.cell}"
    if not tuned.space:
        return [f"{head}: nothing to tune, budget 0"]
    lines = [
        head,
        f"  budget: {tuned.runs} of {told['budget_runs']} runs of {tuned.horizon_s} s used, "
        f"{tuned.simulated_s:,} s",
        "  candidates: "
        + " → ".join(f"{each['candidates']} on {each['seeds']} seeds" for each in told["rungs"])
        + (f"; {told['failed']} failed" if told["failed"] else ""),
    ]
    metric = UNITS[told["metric"]]
    if told["check_seeds"]:
        ends = told["best_over_default_minus_1"]
        percent = [f"{100 * ends[name]:+.1f}".replace("-", "−") for name in ends]
        means = [number(told[name], 2) for name in ("default_mean", "best_mean")]
        lines += [
            f"  {metric}, on {told['check_seeds']} further seeds:",
            f"  defaults {means[0]}, best {means[1]}: {percent[0]} % [{percent[1]}, {percent[2]}]",
        ]
    else:
        lines.append(f"  {metric}: no candidate beats the defaults")
    options = Variant(tuned.controller, tuned.chosen).label.split(",")[1:]
    chosen = "the defaults" if told["defaults_kept"] else ", ".join(options)
    return [*lines, f"  chosen: {chosen}", f"  {path}"]
