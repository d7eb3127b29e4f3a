"""``dmil export``: what a controller did, as SUMO's signal programs and as signal events."""

from __future__ import annotations

import importlib.util
from collections import Counter
from pathlib import Path
from typing import Any

import polars as pl
from pydantic import Field

from dmil.cli.choices import (
    SCENARIO_OPTIONS,
    SimulatorChoice,
    built,
    compile_first,
    scenario_command,
    with_scenario_of,
)
from dmil.cli.controller_choice import ControllerOrPolicy, controller_options
from dmil.cli.export_plan import write_plans
from dmil.cli.parameters import Option, options
from dmil.cli.terminal import number, print_json, say, show, waiting
from dmil.controllers import CONTROLLERS, Controller, make_controller
from dmil.controllers.variants import Variant
from dmil.errors import InputError
from dmil.experiments.contender import FROZEN, Contender, accepted
from dmil.files import write_atomically
from dmil.network.sumo import SumoSignals, write_sumo_network
from dmil.rewards import make_reward
from dmil.scenarios import Scenario
from dmil.scenarios.names import shown
from dmil.scenarios.recipe import ScenarioRecipe
from dmil.seeding import LARGEST_SEED
from dmil.simulation import Simulator, make_simulator
from dmil.simulation.measures import Measures
from dmil.simulation.sumo import SumoSimulator
from dmil.training import Policy, evaluate, vehicles_of_seed
from dmil.training.mean_cycle import MeanCycle, mean_cycles
from dmil.training.signal_events import NONE, EventRecorder, SignalEvent, signal_table

PROGRAMS, EVENTS = "programs.add.xml", "signals.csv"
SHOWN = 10
"""How many warnings are shown."""


class ExportParameters(ControllerOrPolicy, ScenarioRecipe, SimulatorChoice):
    """What is exported."""

    seed: int = Field(0, ge=0, le=LARGEST_SEED, description="Seed of the run.")
    plan_length_s: int | None = Field(
        None, ge=60, description="Make a separate plan for every so many s; by default one."
    )
    network: bool = Field(
        False, description="Also write the network for SUMO, if it does not come from SUMO."
    )
    out: Path = Field(Path("export"), description="Folder to write to.")


OPTIONS = (
    *SCENARIO_OPTIONS,
    Option("simulator", "--simulator", "Run"),
    *controller_options(many=False),
    Option("policy", "--policy", "Controller", "FILE"),
    Option("seed", "--seed", "Run"),
    *options("Output", "plan_length_s --plans; network; out FOLDER"),
)


@scenario_command("export", ExportParameters, OPTIONS)
def export(settings: ExportParameters, json: bool) -> None:
    """Export what a controller did, as signal programs for SUMO and as a table of signal events.

    For example:
        dmil export --policy policy.npz --out plan
        dmil export --scenario resco/cologne8 --controller max-pressure --simulator sumo
        sumo -c city.sumocfg -a plan/programs.add.xml

    The controller runs once, as evaluate runs it: policies frozen, controllers that need no
    training learning from the first second. signals.csv has one row per phase change.
    programs.add.xml has the mean cycle of every intersection: phases in their most frequent order,
    each with its mean duration. SUMO uses it because it is loaded after the network's own. With
    --plans 900 there is one plan for every 15 minutes, switched by time of day. Yellow, all-red,
    minimum greens and offsets are those of the network's own plan, or longer where you asked for
    more; a plan with conflicting greens is not written.

    A fixed-time plan cannot respond to traffic as the controller does: where SUMO is installed,
    both are run in it and compared. A .sumocfg that names additional files needs them before this
    one: -a theirs.add.xml,plan/programs.add.xml
    """
    policy = settings.load_policy()
    scenario = built(with_scenario_of(settings, policy))
    contender = _contender(settings, policy)
    if settings.simulator == "queue":
        compile_first()
    with waiting(f"{contender.label} in {settings.simulator} …"):
        simulator = make_simulator(scenario, settings.simulator)
        events = _run(simulator, contender.make(scenario.network), settings.seed)[1]
    if not any(event.phase != NONE for event in events):
        raise InputError(
            "it runs the network's own program, which needs no export",
            where=f"controller '{contender.label}'",
            mend="a controller that chooses phases",
        )
    _make_folder(settings.out)
    files = [settings.out / EVENTS]
    table = signal_table(events, scenario.network)
    phase = pl.col("phase").cast(pl.String).fill_null("program")
    write_atomically(files[0], table.with_columns(phase=phase).write_csv)
    plans = _plans(settings, scenario, events)
    compared: dict[str, Measures] = {}
    signals: tuple[SumoSignals, ...] = ()
    net_file, begin_s = Path(), 0
    if scenario.sumo:
        signals, begin_s = scenario.sumo.signals, scenario.sumo.begin_s
        net_file = scenario.sumo.net_file
    elif settings.network:
        written = write_sumo_network(scenario.network, settings.out)
        signals, net_file = written.signals, written.net_file
        files.append(net_file)
    if signals:
        files.append(settings.out / PROGRAMS)
        write_plans(files[-1], plans, scenario.network, scenario.timing, signals, net_file, begin_s)
        if scenario.sumo and importlib.util.find_spec("libsumo"):
            with waiting("Running both in SUMO …"):
                compared = _compare(settings, scenario, contender, files[-1])
    notes = [*_worth(settings, policy), *(_notes(scenario, plans) if signals else [])]
    if json:
        print_json(_as_json(scenario, contender, files, plans, compared, notes))
        return
    changes = sum(event.from_phase != NONE for event in events)
    where = f"{shown(scenario.name)}, {scenario.horizon_s} s"
    show(f"{contender.label} on {where}: {changes} phase changes")
    for label, measures in compared.items():
        travel, delay = number(measures.travel_time_s, 1), number(measures.delay_s, 1)
        show(f"  {label:22s} in SUMO: travel time {travel} s, delay {delay} s")
    for note in notes[:SHOWN]:
        show(note)
    if len(notes) > SHOWN:
        show(f"… and {len(notes) - SHOWN} more such notes (all with --json)")
    for file in files:
        say(f"Written: {file}")
    if not signals:
        say(
            "No signal programs: the network does not come from SUMO (--network writes both "
            "network and programs)."
        )


def _contender(settings: ExportParameters, policy: Policy | None) -> Contender:
    if policy:
        return settings.contender(policy)
    # As evaluate runs it: what needs no training learns from the first second.
    choice, entry = settings.controller, CONTROLLERS.get(settings.controller.name)
    frozen = {} if entry is not None and entry.online else accepted(choice.name, FROZEN)
    return Contender(choice.name, Variant(choice.name, frozen | choice.options))


def _worth(settings: ExportParameters, policy: Policy | None) -> list[str]:
    """Say what of a learner the plan is made from."""
    entry = CONTROLLERS.get(settings.controller.name)
    if policy is not None or entry is None or not entry.learns:
        return []
    name = settings.controller.name
    if entry.online:
        return [
            f"The plan records what {name} did in seed {settings.seed} while it learned from the "
            "first second, as evaluate runs it."
        ]
    return [
        f"{name} has learned nothing and is frozen, so the plan is not meaningful. Train it and "
        "export its --policy."
    ]


def _run(
    simulator: Simulator, controller: Controller, seed: int
) -> tuple[Measures, list[SignalEvent]]:
    recorder, reward = EventRecorder(), make_reward("diffusion")
    vehicles = vehicles_of_seed(simulator.scenario, seed)
    run = evaluate(simulator, controller, vehicles, reward, seed, observers=[recorder])
    return run.measures, recorder.events


def _compare(
    settings: ExportParameters, scenario: Scenario, contender: Contender, programs: Path
) -> dict[str, Measures]:
    """Run the controller, its plan and the network's own program in SUMO."""

    def fixed_time(*options: str) -> Measures:
        simulator = SumoSimulator(scenario, further_options=lambda _: options)
        measures = _run(simulator, make_controller("program"), settings.seed)[0]
        simulator.close()
        return measures

    mine, own = make_simulator(scenario, "sumo"), contender.make(scenario.network)
    return {
        contender.label: _run(mine, own, settings.seed)[0],
        "its fixed-time plan": fixed_time("--additional-files", str(programs.resolve())),
        "the network's program": fixed_time(),
    }


def _plans(
    settings: ExportParameters, scenario: Scenario, events: list[SignalEvent]
) -> list[tuple[int, list[MeanCycle]]]:
    length_s = settings.plan_length_s or scenario.horizon_s
    return [
        (
            begin_s,
            mean_cycles(
                events,
                scenario.network,
                begin_s=begin_s,
                end_s=min(begin_s + length_s, scenario.horizon_s),
            ),
        )
        for begin_s in range(0, scenario.horizon_s, length_s)
    ]


def _notes(scenario: Scenario, plans: list[tuple[int, list[MeanCycle]]]) -> list[str]:
    """Say what a plan leaves out or adds."""
    notes: Counter[str] = Counter()
    for _, cycles in plans:
        for item, cycle in zip(scenario.network.intersections, cycles, strict=True):
            for what, phases in (
                ("was rarely shown and is left out", cycle.left_out),
                (
                    "was rarely shown, but keeps a short green: only it serves a movement",
                    cycle.added,
                ),
            ):
                for phase in phases:
                    named = phase < len(item.phase_names) and item.phase_names[phase]
                    notes[f"{item.id}: phase {phase}{f' ({named})' if named else ''} {what}"] += 1
            for j in cycle.never_served:
                movement = item.movements[j]
                way = f"{movement.from_link} to {movement.to_link}"
                notes[f"{item.id}: no phase serves the movement from {way}"] += 1
    several = len(plans) > 1
    return [
        f"{note}, in {count} of {len(plans)} plans" if several else note
        for note, count in notes.items()
    ]


def _make_folder(path: Path) -> None:
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"cannot be made ({error.strerror})", where=str(path), expected="a folder"
        ) from None


def _as_json(
    scenario: Scenario,
    contender: Contender,
    files: list[Path],
    plans: list[tuple[int, list[MeanCycle]]],
    compared: dict[str, Measures],
    notes: list[str],
) -> dict[str, Any]:
    return {
        "scenario": scenario.name,
        "controller": contender.label,
        "files": files,
        "plans": [
            {
                "since_s": since_s,
                "intersections": [
                    {"id": item.id, "phases": cycle.phases, "green_s": cycle.green_s}
                    for item, cycle in zip(scenario.network.intersections, cycles, strict=True)
                ],
            }
            for since_s, cycles in plans
        ],
        "in_sumo": {
            label: {"travel_time_s": each.travel_time_s, "delay_s": each.delay_s}
            for label, each in compared.items()
        },
        "notes": notes,
    }
