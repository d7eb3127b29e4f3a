"""A made-up study on the RESCO benchmark with known answers, in the shape of a real one."""

from itertools import product
from types import MappingProxyType

import numpy as np
import polars as pl

from dmil.results import RUNS_SCHEMA, SERIES_SCHEMA, TABLES, write_manifest, write_results
from dmil.seeding import stream

SUMO, UNBLOCKED, CALIBRATED, QUEUE = "sumo", "sumo-unblocked", "queue-calibrated", "queue"
SIMULATORS = (SUMO, CALIBRATED, QUEUE)
LOCKING = "random"
"""Whose first seed locks at 1,200 s in SUMO, unless blockers are ignored."""
SCENARIOS = ("resco/cologne1", "resco/ingolstadt21", "resco/grid4x4", "resco/arterial4x4")
DELAY_S = {  # in SUMO on the first network; the others have multiples of it
    ("program", None, False): 60.0,
    ("actuated", None, False): 45.0,
    ("longest-queue-first", None, False): 30.0,
    ("max-pressure", None, False): 40.0,
    ("random", None, False): 150.0,
    ("sarsa", "exact", False): 50.0,
    ("dual-memory", "simple", False): 29.0,
    ("dual-memory", "simple", True): 28.0,
    ("dual-memory", "complex", False): 35.0,
    ("dual-memory", "complex", True): 34.0,
    ("dual-memory", "cells", False): 27.0,
    ("dual-memory", "cells", True): 26.0,
}
CONTENDERS = tuple(DELAY_S)
FACTOR = {CALIBRATED: 0.9, QUEUE: 0.5, SUMO: 1.0, UNBLOCKED: 1.0}
EPISODES = 20


def expected_delay(contender, simulator, place=0):
    """In the queue simulator two controllers change ranks before calibration."""
    delay_s = DELAY_S[contender]
    if simulator == QUEUE and contender[0] in ("program", "sarsa"):
        delay_s = 110.0 - delay_s  # 60 and 50 change places
    return FACTOR[simulator] * delay_s * (1 + place)


def write_resco_study(
    folder,
    *,
    scenarios=SCENARIOS,
    seeds=5,
    contenders=CONTENDERS,
    simulators=SIMULATORS,
    episodes=EPISODES,
    spread=0.02,
    failed=(),
    trained_in=MappingProxyType({}),
):
    """Write a folder of results; ``failed`` holds (controller, simulator) whose runs failed.

    Learners trained in the calibrated queue simulator, or where ``trained_in`` says.
    """
    runs, series, training = [], [], []
    for place, scenario in enumerate(scenarios):
        demand = np.array([stream(seed, scenario).normal(0, 0.1) for seed in range(seeds)])
        for contender in contenders:
            key = _key(scenario, contender)
            place_of_training = trained_in.get(contender[0], CALIBRATED)
            rng = stream(3, scenario, *map(str, contender))
            luck = rng.normal(0, spread, seeds)
            if key["reward"]:
                end = DELAY_S[contender] * (1 + place)
                training.append(_episodes(key, seeds, episodes, end, place_of_training))
            for simulator in simulators:
                if contender[0] == "actuated" and simulator != SUMO:
                    continue
                base = expected_delay(contender, simulator, place)
                delay = base * (1 + demand) * (1 + luck * (simulator == SUMO))
                here = key | {"simulator": simulator}
                status = "SimulationError: SUMO died" if (contender[0], simulator) in failed else ""
                vehicles = 2000 * (1 + place)
                runs.append(_runs(here, delay, vehicles, status, place_of_training))
                if not status:
                    series.append(_series(here, delay))
    tables = {"runs": runs, "series": series, "episodes": training}
    empty = {name: pl.DataFrame(schema=table.schema) for name, table in TABLES.items()}
    write_results(folder, *(pl.concat([empty[name], *rows]) for name, rows in tables.items()))
    configuration = {"scenarios": [name.removeprefix("resco/") for name in scenarios]}
    configuration |= {"seeds": seeds, "episodes": episodes, "train_in": "queue", "judge": SUMO}
    write_manifest(
        folder,
        {
            "study": "resco",
            "configuration": configuration,
            "command": "dmil study resco",
            "started": "2025-01-01T10:00:00",
            "finished": "2025-01-01T10:01:00",
            "wall_s": 60.0,
        },
    )
    return folder


def _key(scenario, contender):
    controller, embedding, communication = contender
    learns = embedding is not None
    return {
        "preset": "resco",
        "scenario": scenario,
        "controller": controller,
        "embedding": embedding,
        "communication": communication,
        "reward": "diffusion" if learns else None,
        "epsilon": 0.1 if learns else None,
    }


def _frame(key, schema, **columns):
    constant = {name: pl.lit(value, schema[name]) for name, value in key.items()}
    frame = pl.DataFrame(columns).with_columns(
        **constant, **{n: pl.lit(None, t) for n, t in schema.items() if n not in columns | key}
    )
    return frame.select(pl.col(name).cast(dtype) for name, dtype in schema.items())


def _runs(key, delay, vehicles, status, trained_in):
    seeds = len(delay)
    learns = key["reward"] is not None
    sumo = key["simulator"] == SUMO
    measures = {
        "spawned_veh": np.full(seeds, vehicles),
        "arrived_veh": np.full(seeds, vehicles - 20),
        "wait_veh_s": (0.7 * delay * vehicles).astype(int),
        "wait_per_spawned_s": 0.7 * delay,
        "w_over_vc": 0.7 * delay / vehicles,
        "mean_queue_veh": 0.7 * delay * vehicles / 3600,
        "travel_time_s": delay + 60,
        "delay_s": delay,
        "throughput_veh_per_h": vehicles - delay,
        "stops_per_spawned": delay / 30,
        "overruled": np.zeros(seeds),
        "entries_per_agent": np.full(seeds, 500.0 if learns else 0.0),
        "bytes_total": np.full(seeds, _bytes(key)),
    }
    if sumo:
        measures |= {"locked_from_s": [1200 if each else None for each in _locks(key, seeds)]}
        measures |= {"co2_g": 200 * vehicles + 4000 * delay, "fuel_g": 60 * vehicles + 1000 * delay}
    if key["simulator"] in (SUMO, UNBLOCKED):
        measures |= {"locked": [int(sumo and each) for each in _locks(key, seeds)]}
    if status:
        measures = {}
    return _frame(
        key,
        RUNS_SCHEMA,
        seed=np.arange(seeds),
        study=["resco"] * seeds,
        trained_in=[trained_in if learns else None] * seeds,
        horizon_s=np.full(seeds, 3600),
        status=[status or "ok"] * seeds,
        **measures,
    )


def _locks(key, seeds):
    return (np.arange(seeds) == 0) & (key["controller"] == LOCKING)


def _bytes(key):
    if key["reward"] is None:
        return 0
    size = {"exact": 900_000, "simple": 400_000, "complex": 90_000, "cells": 30_000}
    return size[key["embedding"]] * (2 if key["communication"] else 1)


def _series(key, delay):
    times = np.arange(0, 3601, 10)
    shape = 1 + np.sin(np.pi * times / 3600)
    return _frame(
        key,
        SERIES_SCHEMA,
        seed=np.repeat(np.arange(len(delay)), len(times)),
        time_s=np.tile(times, len(delay)),
        queue_veh=np.outer(delay, shape).round().astype(int).ravel(),
        arrived_veh=np.tile(times, len(delay)),
    )


def _episodes(key, seeds, episodes, end, trained_in):
    rows = np.array(list(product(range(seeds), range(episodes))))
    delay = end * (1 + 2 / (1 + rows[:, 1])) + rows[:, 0]
    return _frame(
        key,
        TABLES["episodes"].schema,
        seed=rows[:, 0],
        episode=rows[:, 1],
        trained_in=[trained_in] * len(rows),
        delay_s=delay,
        travel_time_s=delay + 60,
        wait_per_spawned_s=0.7 * delay,
        entries_per_agent=50.0 + 20 * rows[:, 1],
    )
