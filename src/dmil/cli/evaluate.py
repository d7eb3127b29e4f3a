"""``dmil evaluate``: controllers and policies side by side, on the same vehicles."""

from __future__ import annotations

import json as json_module
import re
import textwrap
from pathlib import Path
from typing import Any

import typer
from pydantic import Field, field_validator
from rich import box
from rich.table import Table
from rich.text import Text

from dmil.cli.application import StoppedError
from dmil.cli.choices import (
    REWARD,
    SCENARIO_OPTIONS,
    SIMULATOR_OPTIONS,
    ControllerChoice,
    SimulatorChoice,
    accepted,
    complete_scenario,
    controller_options,
    with_scenario_of,
)
from dmil.cli.help import Command
from dmil.cli.measures import UNFINISHED, Measure, number
from dmil.cli.parameters import Option, settings_command
from dmil.cli.terminal import print_json, progress, results, say, show, waiting
from dmil.compilation import is_cold
from dmil.controllers import CONTROLLERS
from dmil.errors import InputError
from dmil.rewards import make_reward
from dmil.scenarios import Scenario
from dmil.scenarios.recipe import ScenarioRecipe
from dmil.seeding import LARGEST_SEED
from dmil.statistics import Estimate
from dmil.studies import LocalExecutor, compile_kernels
from dmil.studies.comparison import REFERENCE, Comparison, Contender, compare
from dmil.training import Policy, load_policy

BASELINES = ("fixed-cycle", "longest-queue-first", "max-pressure")
DIFFERENCES = ("travel_time_s", "wait_per_spawned_s")
SHOWN = (
    Measure("travel_time_s", "travel time", "s", 1),
    Measure("wait_per_spawned_s", "W, waiting", "s", 1),
    Measure("throughput_veh_per_h", "throughput", "veh/h", 0),
    Measure("mean_queue_veh", "mean queue", "veh", 1),
    Measure("entries_per_agent", "memory entries", "per intersection", 1, True),
    Measure("bytes_per_intersection", "memory bytes", "per intersection", 0, True),
)
LABEL_WIDTH, COLUMN_WIDTH = 16, 15


class EvaluateParameters(ScenarioRecipe, SimulatorChoice):
    """A comparison."""

    controller: tuple[ControllerChoice, ...] = Field(
        (), description="Controller to judge; may be repeated."
    )
    policy: tuple[Path, ...] = Field((), description="Policy to judge; may be repeated.")
    changes: dict[str, Any] = Field(
        {}, description="Settings that go over those of all judged controllers and policies."
    )
    reward: str = Field("diffusion", description=REWARD)
    seeds: int = Field(10, ge=1, description="Number of test seeds.")
    seed: int = Field(0, ge=0, le=LARGEST_SEED, description="First of the seeds.")
    baselines: bool = Field(
        True, description="Put fixed-cycle, longest-queue-first and max-pressure beside."
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
    Option("baselines", "--baselines", "Controllers"),
    Option("learn", "--learn", "Test"),
    Option("epsilon", "--epsilon", "Test"),
    Option("reward", "--reward", "Test"),
    Option("seeds", "--seeds", "Test"),
    Option("seed", "--seed", "Test"),
    Option("jobs", "--jobs", "Test"),
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
        dmil evaluate --scenario grid:3x3 --controller mine:MyController

    In each seed all controllers meet the same vehicles. The table shows means over seeds with 95 %
    bootstrap intervals, and the paired difference to max-pressure: an interval wholly below 0 means
    less time than max-pressure needs. Travel time runs from departure to arrival, W is the part of
    it spent in queues, both in s per vehicle.

    A policy, or a controller that learns, is frozen by default: it does not learn, and always takes
    the action it holds best (ε = 0). Then the seeds tell how good what it has learned is.
    """
    if not settings.policy and not settings.controller and not settings.baselines:
        raise InputError("nobody to judge", where="evaluate", mend="add --controller or --policy")
    policies = [load_policy(path) for path in settings.policy]
    recipe = with_scenario_of(settings, policies[0] if policies else None)
    scenario = recipe.build()
    contenders = _contenders(settings, policies)
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
                executor=executor,
                progress=advance,
            )
    except KeyboardInterrupt:
        raise StoppedError("nothing is kept of a comparison") from None
    notes = _notes(settings, found, scenario)
    if json:
        print_json(_as_json(found, scenario, notes))
        return
    seed_text = f"{len(seeds)} seeds" if len(seeds) > 1 else f"seed {seeds[0]}"
    show(f"{scenario.name}, {scenario.horizon_s} s, {seed_text}", "")
    # As many controllers side by side as the terminal is wide.
    fitting = max(1, (results().width - LABEL_WIDTH) // (COLUMN_WIDTH + 1))
    for first in range(0, len(found.labels), fitting):
        show(_table(found, range(len(found.labels))[first : first + fitting]), "")
    for note in notes:
        show(note)


def _contenders(settings: EvaluateParameters, policies: list[Policy]) -> list[Contender]:
    """Return everyone who runs; those to judge first, each with a label of its own."""
    made: dict[str, Contender] = {}

    def add(label: str, contender: dict[str, Any]) -> None:
        unique, count = label, 2
        while unique in made:
            unique, count = f"{label} ({count})", count + 1
        made[unique] = Contender(unique, **contender)

    mode = _mode(settings)
    for path, policy in zip(settings.policy, policies, strict=True):
        options = accepted(policy.controller, mode) | settings.changes
        add(
            path.name,
            {"options": json_module.dumps(options), "policy": str(path), "reward": policy.reward},
        )
    for choice in settings.controller:
        options = choice.options | accepted(choice.name, mode) | settings.changes
        make_reward(settings.reward)
        add(
            choice.name,
            {
                "controller": choice.name,
                "options": json_module.dumps(options),
                "reward": settings.reward,
            },
        )
        if options.get("learning") is False:
            say(f"{choice.name} has learned nothing yet and is frozen: train it, or add --learn.")
    for name in BASELINES if settings.baselines else ():
        if name not in made:
            add(name, {"controller": name})
    return list(made.values())


def _mode(settings: EvaluateParameters) -> dict[str, Any]:
    """Return the options that freeze a learner, or let it learn."""
    mode: dict[str, Any] = {"learning": settings.learn}
    if settings.epsilon is not None:
        mode["epsilon"] = settings.epsilon
    elif not settings.learn:
        mode["epsilon"] = 0.0
    return mode


def _notes(settings: EvaluateParameters, found: Comparison, scenario: Scenario) -> list[str]:
    notes = [UNFINISHED]
    several = len(found.seeds) > 1
    if several:
        notes.append("Below each mean: its 95 % bootstrap interval over seeds.")
    if found.same_demand:
        notes.append(
            "The vehicles are recorded, the same in every seed: only chance inside the controllers "
            "differs, so the interval of one that draws nothing is exact."
        )
    elif several:
        notes.append("Each seed has vehicles of its own, the same for all controllers.")
    entries = [CONTROLLERS.get(choice.name) for choice in settings.controller]
    if settings.policy or any(entry and entry.learns for entry in entries):
        epsilon = "their own" if settings.epsilon is None else f"{settings.epsilon:g}"
        frozen = f"frozen, ε = {settings.epsilon or 0:g}"
        notes.append(f"Learners: {f'learning, ε = {epsilon}' if settings.learn else frozen}.")
    timing = scenario.timing
    notes.append(
        f"Decisions every {timing.decision_interval_s} s, clearance {timing.clearance_s} s, "
        f"minimum green {timing.min_green_s} s."
    )
    return notes


def _table(found: Comparison, columns: range) -> Table:
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, padding=0)
    table.add_column("", width=LABEL_WIDTH, no_wrap=True)
    for i in columns:
        parts = re.split("(?<=:)", found.labels[i])
        head = "\n".join(line for part in parts for line in textwrap.wrap(part, COLUMN_WIDTH))
        table.add_column(head, width=COLUMN_WIDTH, justify="right", overflow="fold")
    for measure in SHOWN:
        if measure.optional and not found.measures[measure.name].any():
            continue
        mean = found.mean(measure.name)
        # What a frozen policy remembers is not a matter of chance.
        fixed = measure.optional and not found.measures[measure.name].std(axis=0).any()
        cells = (_cell(mean, i, measure.digits, plain=fixed) for i in columns)
        table.add_row(_label(measure), *cells)
        difference = found.difference(measure.name) if measure.name in DIFFERENCES else None
        if difference is not None:
            cells = (
                "" if found.labels[i] == REFERENCE else _cell(difference, i, measure.digits, "+")
                for i in columns
            )
            table.add_row(Text(f"− {REFERENCE}", "dim"), *cells)
    return table


def _label(measure: Measure) -> Text:
    return Text.assemble(measure.label, "\n", (measure.unit, "dim"))


def _cell(estimate: Estimate, i: int, digits: int, sign: str = "", *, plain: bool = False) -> str:
    """Return a mean, and its interval on a second line unless that is not wanted."""
    value, low, high = (float(each[i]) for each in (estimate.value, estimate.low, estimate.high))
    if value == low == high == 0 and not sign:
        return "0"
    mean = number(value, digits, sign)
    return (
        mean if low != low or plain else f"{mean}\n[{number(low, digits)}, {number(high, digits)}]"
    )


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
                f"minus_{REFERENCE}": {
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
