"""``dmil simulate``: run one controller on one scenario."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import polars as pl
from pydantic import Field
from rich.table import Table

from dmil.cli.choices import (
    SCENARIO_OPTIONS,
    SIMULATOR_OPTIONS,
    RewardChoice,
    SimulatorChoice,
    built,
    compile_first,
    say_stand_ins,
    scenario_command,
    with_scenario_of,
)
from dmil.cli.controller_choice import ControllerOrPolicy, controller_options
from dmil.cli.parameters import options
from dmil.cli.terminal import UNFINISHED, number, print_json, say, show, table
from dmil.errors import InputError, OutputError
from dmil.experiments.trial import run_row
from dmil.results.metrics import METRICS, RUN_TABLE
from dmil.rewards import PAPER_CONSTANTS
from dmil.scenarios.names import shown
from dmil.scenarios.recipe import ScenarioRecipe
from dmil.seeding import LARGEST_SEED, stream
from dmil.simulation import make_simulator
from dmil.statistics import mean_interval
from dmil.training import evaluate, vehicles_of_seed
from dmil.training.recording import Recording

SERIES_ENDINGS = (".csv", ".parquet")


class SimulateParameters(ControllerOrPolicy, ScenarioRecipe, SimulatorChoice, RewardChoice):
    """One controller on one scenario."""

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
    record: Path | None = Field(
        None,
        description="Write what happened to this folder, as Parquet: V_c and queue of every "
        "second, memory in use, queues and crossings, changes of phase (docs/results.md).",
    )


OPTIONS = (
    *SCENARIO_OPTIONS,
    *SIMULATOR_OPTIONS,
    *controller_options(many=False),
    *options("Controller", "policy FILE; reward"),
    *options("Runs", "seed; seeds"),
    *options("Output", "series FILE; record FOLDER"),
)


@scenario_command("simulate", SimulateParameters, OPTIONS)
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
    policy = settings.load_policy("leave out --policy or --controller; dmil evaluate compares both")
    if policy and settings.reward_constants not in (PAPER_CONSTANTS, policy.reward_constants):
        raise InputError(
            "other constants of the reward than those the policy learned from",
            where="reward_constants",
            mend="leave them out: the policy brings its own",
        )
    recipe = with_scenario_of(settings, policy)
    scenario = built(recipe)
    contender = settings.contender(policy)
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
    rows, recording = [], Recording(scenario.network)
    observers = recording.observers if settings.series or settings.record else ()
    seeds = range(settings.seed, settings.seed + settings.seeds)
    compile_first()
    for seed in seeds:
        vehicles = vehicles_of_seed(scenario, seed)
        controller = contender.make(scenario.network)
        run = evaluate(simulator, controller, vehicles, reward, seed, observers=observers)
        rows.append({"seed": seed} | run_row(run, scenario.network))
        if observers:
            recording.add(seed, run)
    if settings.series:
        recording.write("seconds", settings.series)
    if settings.record:
        for name in recording.tables:
            recording.write(name, settings.record / f"{name}.parquet")
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
    if settings.record:
        say(f"Recorded: {settings.record}")


def _table(rows: list[dict[str, Any]]) -> Table:
    """Return one value for one run; mean with interval, and the seeds' extremes, for several."""
    several = len(rows) > 1
    heads = (">mean", ">95 % interval") if several else (">value",)
    made = table("!measure", *heads, "!unit", padding=(0, 1))
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
        made.add_row(metric.label, *cells, metric.unit)
    return made
