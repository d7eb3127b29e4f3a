"""``dmil calibrate``: calibrate the queue simulator from one run of SUMO."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field
from rich.table import Table

from dmil.cli.choices import (
    SCENARIO_OPTIONS,
    built,
    compile_first,
    recipe_of,
    scenario_command,
)
from dmil.cli.parameters import Option
from dmil.cli.terminal import number, print_json, progress, say, show, table, waiting
from dmil.errors import InputError
from dmil.scenarios import Scenario
from dmil.scenarios.calibration import Calibration
from dmil.scenarios.names import shown
from dmil.scenarios.recipe import ScenarioRecipe
from dmil.seeding import LARGEST_SEED
from dmil.training.agreement import CALIBRATED, JUDGE, PLAIN, Agreement, agreement
from dmil.training.calibration import SEED
from dmil.training.calibration import calibrate as calibrated

COMPARED = ("max-pressure", "longest-queue-first")


class CalibrateParameters(ScenarioRecipe):
    """A calibration of the queue simulator."""

    seed: int = Field(
        SEED,
        ge=0,
        le=LARGEST_SEED,
        description="Seed of the measured run, far from test seeds.",
    )
    seeds: int = Field(
        1, ge=0, description="Test seeds on which the simulators are compared; 0: no comparison."
    )
    out: Path = Field(Path("calibration.json"), description="File to write.")


OPTIONS = (
    *(option for option in SCENARIO_OPTIONS if option.path != "calibration"),
    Option("seed", "--seed", "Measurement"),
    Option("seeds", "--seeds", "Comparison"),
    Option("out", "--out", "Output", "FILE"),
)


@scenario_command("calibrate", CalibrateParameters, OPTIONS)
def calibrate(settings: CalibrateParameters, json: bool) -> None:
    """Calibrate the queue simulator from one run of SUMO.

    For example:
        dmil calibrate --scenario resco/cologne8
        dmil calibrate --scenario sumo:city.sumocfg --out city.json --seeds 3
        dmil train --scenario resco/cologne8 --calibration calibration.json --out policy.npz

    Under the network's own signal program, or max-pressure where it has none, SUMO's detectors give
    the headways behind standing queues, the time lost at the beginning of green, and the time that
    undisturbed vehicles need for every link, junctions included. The second table shows how far the
    queue simulator is from SUMO without and with them, in runs other than the measured one.

    simulate, train and evaluate take the file as --calibration; it is valid for the same network
    only.
    """
    if settings.calibration is not None:
        raise InputError(
            "calibration starts from the scenario's own values",
            where="calibration",
            mend="leave it out",
        )
    scenario = built(recipe_of(settings))
    with waiting("One run of SUMO …"):
        found = calibrated(scenario, settings.seed)
    found.save(settings.out)
    compared: list[Agreement] = []
    if settings.seeds:
        compile_first()
        programs = all(item.program for item in scenario.network.intersections)
        controllers = (("program",) if programs else ()) + COMPARED
        with progress("runs") as advance:
            compared = agreement(
                scenario, found, controllers, range(settings.seeds), progress=advance
            )
    if json:
        print_json(_as_json(found, compared, settings.out))
        return
    show(f"{shown(scenario.name)}, {scenario.horizon_s} s under {found.controller}", "")
    show(_measured(found, scenario))
    if compared:
        show("", _compared(compared))
    say(f"Written: {settings.out}")


def _measured(found: Calibration, scenario: Scenario) -> Table:
    made = table("measured", ">before", ">now", "!unit", padding=(0, 1))
    dynamics, timing, network = scenario.dynamics, scenario.timing, scenario.network
    flow = dynamics.saturation_flow_veh_per_s, found.saturation_flow_veh_per_s
    wave = dynamics.start_wave_veh_per_s, found.start_wave_veh_per_s
    lost = timing.startup_lost_s, found.startup_lost_s
    time = float(network.free_flow_time_s.mean()), float(np.mean(found.link_time_s))
    free = time[0], float(np.mean(found.link_free_s))
    for what, (before, now), digits, unit in (
        ("saturation flow", flow, 3, "veh/s per lane"),
        ("start-up lost time", lost, 0, "s"),
        ("start wave", wave, 1, "veh/s per lane"),
        ("time on a link, mean", time, 1, "s"),
        ("of this, not lost", free, 1, "s"),
    ):
        made.add_row(what, number(before, digits), number(now, digits), unit)
    made.caption = f"{found.headways} headways, {found.passages} undisturbed passages of links"
    return made


def _compared(compared: list[Agreement]) -> Table:
    heads = ("!controller", "!measure, s", ">SUMO", ">queue before", ">now")
    made = table(*heads, padding=(0, 1))
    for each in compared:
        for label, values in (("travel time", each.travel_time_s), ("delay", each.delay_s)):
            judged = values[JUDGE]
            cells = [
                f"{number(values[name], 1)} ({number(100 * (values[name] / judged - 1), 0, '+')} %)"
                for name in (PLAIN, CALIBRATED)
            ]
            name = each.controller if label == "travel time" else ""
            made.add_row(name, label, number(judged, 1), *cells)
    return made


def _as_json(found: Calibration, compared: list[Agreement], out: Path) -> dict[str, Any]:
    return {
        "file": out,
        "calibration": found.model_dump(),
        "comparison": [
            {
                "controller": each.controller,
                "travel_time_s": each.travel_time_s,
                "delay_s": each.delay_s,
            }
            for each in compared
        ],
    }
