"""``dmil simulate``: run one controller on one scenario."""

from __future__ import annotations

import contextlib
import json as json_module
from pathlib import Path
from typing import Any

import polars as pl
import typer
from pydantic import Field
from rich import box
from rich.table import Table

from dmil.cli.building import built, say_stand_ins
from dmil.cli.choices import (
    SCENARIO_OPTIONS,
    SIMULATOR_OPTIONS,
    ControllerChoice,
    RewardChoice,
    SimulatorChoice,
    accepted,
    complete_scenario,
    controller_options,
    files_as_settings,
    policy_from,
    with_scenario_of,
)
from dmil.cli.help import Command
from dmil.cli.measures import UNFINISHED, number
from dmil.cli.parameters import Option, settings_command
from dmil.cli.terminal import print_json, say, show, waiting
from dmil.compilation import is_cold
from dmil.errors import InputError, OutputError
from dmil.experiments.comparison import Contender
from dmil.experiments.trial import measures_row
from dmil.experiments.warm_up import compile_kernels
from dmil.files import write_atomically
from dmil.results.metrics import METRICS, RUN_TABLE
from dmil.rewards import PAPER_CONSTANTS
from dmil.scenarios import Scenario
from dmil.scenarios.names import shown
from dmil.scenarios.recipe import ScenarioRecipe
from dmil.seeding import LARGEST_SEED, stream
from dmil.simulation import make_simulator
from dmil.statistics import mean_interval
from dmil.training import Policy, Run, evaluate, vehicles_of_seed

DEFAULT_CONTROLLER = "max-pressure"
SERIES_ENDINGS = (".csv", ".parquet")


class SimulateParameters(ScenarioRecipe, SimulatorChoice, RewardChoice):
    """One controller on one scenario."""

    controller: ControllerChoice = Field(
        ControllerChoice(name=DEFAULT_CONTROLLER),
        description="Controller: a name (see dmil controllers) or package.module:Class.",
    )
    policy: Path | None = Field(
        None, description="Policy of a trained controller instead; it runs frozen and greedy."
    )
    seed: int = Field(
        0,
        ge=0,
        le=LARGEST_SEED,
        description="Seed of demand and random choices; the first of several.",
    )
    seeds: int = Field(1, ge=1, description="Number of seeds.")
    series: Path | None = Field(
        None,
        description="Write V_c and queue for every second to this file, .csv or .parquet.",
    )


OPTIONS = (
    *SCENARIO_OPTIONS,
    *SIMULATOR_OPTIONS,
    *controller_options(many=False),
    Option("policy", "--policy", "Controller", "FILE"),
    Option("reward", "--reward", "Controller"),
    Option("seed", "--seed", "Runs"),
    Option("seeds", "--seeds", "Runs"),
    Option("series", "--series", "Output", "FILE"),
)

app = typer.Typer(add_completion=False)


def _complete(settings: SimulateParameters) -> SimulateParameters:
    changes = complete_scenario(settings) | {"controller": settings.controller.complete()}
    return settings.model_copy(update=changes)


@app.command(cls=Command)
@settings_command(
    "simulate", SimulateParameters, OPTIONS, complete=_complete, files=files_as_settings
)
def simulate(settings: SimulateParameters, json: bool) -> None:
    """Run one controller on one scenario and print what was measured.

    For example:
        dmil simulate --scenario grid:5x5
        dmil simulate --scenario grid:3x3 --controller sarsa,embedding=cells
        dmil simulate --scenario cityflow:FOLDER --steps 3600 --seeds 5
        dmil simulate --policy policy.npz --series run.csv

    A run begins with an empty network. In each step of 1 s vehicles arrive, move, and discharge
    from queues with green; every decision interval the controller chooses phases. The main metrics:
    V_c, vehicles that reached their destination; W, the mean time that a vehicle waits in queues;
    W/V_c, the paper's headline metric; travel time from departure to arrival. Vehicles that have
    not arrived count with their time up to the end of the run.

    A learning controller starts with an empty memory and learns during the run, unless it comes
    from a policy. Times are in s, rates in vehicles per s, lengths in m.
    """
    policy = policy_from(settings.policy)
    if policy and settings.controller.name not in (DEFAULT_CONTROLLER, policy.controller):
        raise InputError(
            f"controller '{settings.controller.name}' beside a policy of '{policy.controller}'",
            where=str(settings.policy),
            expected="one of the two",
            mend="leave out --policy or --controller; dmil evaluate compares both",
        )
    if policy and settings.reward_constants not in (PAPER_CONSTANTS, policy.reward_constants):
        raise InputError(
            "other constants of the reward than those the policy learned from",
            where="reward_constants",
            mend="leave them out: the policy brings its own",
        )
    recipe = with_scenario_of(settings, policy)
    scenario = built(recipe)
    contender = _contender(settings, policy)
    reward = (policy or settings).make_reward()
    contender.make(scenario.network)
    if settings.series and settings.series.suffix not in SERIES_ENDINGS:
        raise OutputError(
            f"the file ends in '{settings.series.suffix}'",
            where="--series",
            expected=" or ".join(SERIES_ENDINGS),
        )
    simulator = make_simulator(scenario, settings.simulator, emissions=settings.emissions)
    say_stand_ins(scenario, settings.simulator, [settings.controller.name])
    rows, series = [], []
    seeds = range(settings.seed, settings.seed + settings.seeds)
    with contextlib.ExitStack() as stack:
        if is_cold():
            stack.enter_context(waiting("First start: compiling kernels, once …"))
            compile_kernels()
        for seed in seeds:
            vehicles = vehicles_of_seed(scenario, seed)
            run = evaluate(simulator, contender.make(scenario.network), vehicles, reward, seed)
            rows.append({"seed": seed} | _row(run, scenario))
            series.append(_series(run, seed))
    if settings.series:
        _write_series(pl.concat(series), settings.series)
    if json:
        print_json(
            {
                "scenario": scenario.name,
                "controller": contender.label,
                "simulator": settings.simulator,
                "horizon_s": scenario.horizon_s,
                "runs": rows,
                "series": settings.series,
            }
        )
        return
    seed_text = f"seeds {seeds[0]}–{seeds[-1]}" if len(seeds) > 1 else f"seed {seeds[0]}"
    show(f"{contender.label} on {shown(scenario.name)}, {scenario.horizon_s} s, {seed_text}", "")
    show(_table(rows), UNFINISHED)
    if settings.series:
        say(f"Every second of it: {settings.series}")


def _contender(settings: SimulateParameters, policy: Policy | None) -> Contender:
    options = settings.controller.options
    if policy is None or settings.policy is None:
        return Contender(
            settings.controller.label, settings.controller.name, json_module.dumps(options)
        )
    frozen = accepted(policy.controller, {"learning": False, "epsilon": 0.0})
    return Contender(
        settings.policy.name,
        options=json_module.dumps(frozen | options),
        policy=str(settings.policy),
    )


def _row(run: Run, scenario: Scenario) -> dict[str, Any]:
    row = measures_row(run.measures, run.memory[-1])
    row["bytes_per_intersection"] = row["bytes_total"] / len(scenario.network.intersections)
    return row


def _series(run: Run, seed: int) -> pl.DataFrame:
    measures = run.measures
    return pl.DataFrame(
        {
            "seed": pl.Series([seed] * measures.time_s, dtype=pl.Int64),
            "time_s": pl.Series(range(1, measures.time_s + 1), dtype=pl.Int64),
            "arrived_veh": pl.Series(measures.arrived_at, dtype=pl.Int64),
            "queue_veh": pl.Series(measures.queued_at, dtype=pl.Int64),
        }
    )


def _write_series(table: pl.DataFrame, path: Path) -> None:
    write_atomically(path, table.write_csv if path.suffix == ".csv" else table.write_parquet)


def _table(rows: list[dict[str, Any]]) -> Table:
    """Return one value for one run; mean with interval, and the seeds' extremes, for several."""
    several = len(rows) > 1
    table = Table(box=box.SIMPLE_HEAD, show_edge=False)
    table.add_column("measure", no_wrap=True)
    table.add_column("mean" if several else "value", justify="right", no_wrap=True)
    if several:
        table.add_column("95 % interval", justify="right", no_wrap=True)
    table.add_column("unit", no_wrap=True)
    frame = pl.DataFrame(rows)
    shown = [n for n in RUN_TABLE if not METRICS[n].optional or (frame[n] != 0).any()]
    values = frame.select(shown).cast(pl.Float64).to_numpy()
    estimate = mean_interval(values, stream(0, "bootstrap", "simulate"))
    for i, metric in enumerate(METRICS[name] for name in shown):
        digits = metric.digits if metric.fine_digits is None else metric.fine_digits
        cells = [number(float(estimate.value[i]), digits)]
        if several:
            ends = (number(float(end[i]), digits) for end in (estimate.low, estimate.high))
            cells.append(f"[{', '.join(ends)}]")
        table.add_row(metric.label, *cells, metric.unit)
    return table
