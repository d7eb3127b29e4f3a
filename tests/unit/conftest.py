"""A made-up study with known answers, in the shape of a real one."""

from itertools import product

import numpy as np
import polars as pl
import pytest

from dmil.results import RUNS_SCHEMA, SERIES_SCHEMA, Results, write_manifest, write_results
from dmil.seeding import stream
from dmil.studies.memories.tables import memories_tables
from tests.unit.made_up_memories import write_made_up_study
from tests.unit.made_up_resco import write_resco_study

WAIT = {"default": 0.2, "entropy": 0.1, "diffusion": 0.1, None: 1.0}
ARRIVED = {"default": 0.6, "entropy": 0.9, "diffusion": 0.9, None: 1.0}
CLASSES = {"exact": 1.0, "simple": 0.8, "complex": 0.7, "complex-scaled": 0.75, None: 1.0}
BASELINES = {
    "longest-queue-first": 0.045,
    "max-pressure": 0.047,
    "fixed-cycle": 0.07,
    "random": 0.23,
}


def cells_of_a_study(rewards=("default", "entropy", "diffusion")):
    """The cells of the paper's study on one grid: 16 per reward, three variants, four baselines."""
    sarsa = product(("simple", "complex"), (False, True), (0.6, 0.4))
    agents = [("sarsa", "exact", False, 0.6), ("sarsa", "exact", False, 0.4)]
    agents += [("sarsa", *rest) for rest in sarsa]
    classes = ("simple", "complex", "complex-scaled")
    agents += [("dual-memory", *r, 0.4) for r in product(classes, (False, True))]
    names = ("controller", "embedding", "communication", "epsilon")
    for reward, agent in product(rewards, agents):
        yield {"reward": reward, **dict(zip(names, agent, strict=True)), "variant": None}
    for variant in ("communication=false", "communication=true", "sent=both"):
        if "entropy" in rewards:
            communicates = variant != "communication=false"
            agent = dict(zip(names, ("dual-memory", "complex", communicates, 0.4), strict=True))
            yield {"reward": "entropy", **agent, "variant": variant}
    for baseline in BASELINES:
        agent = dict(zip(names, (baseline, None, False, None), strict=True))
        yield {"reward": None, **agent, "variant": None}


def expected(cell, scenario):
    """Means of a cell: wait (W/V_c), share of vehicles arrived, rows at first and per decision."""
    size = int(scenario[-1])
    if cell["reward"] is None:
        return {"wait": BASELINES[cell["controller"]], "arrived": 0.9, "start": 0.0, "slope": 0.0}
    wait = WAIT[cell["reward"]] * CLASSES[cell["embedding"]]
    if cell["variant"] == "communication=false":
        wait *= 1.2
    # Under the default reward the complex classes are a disadvantage, and so is one intersection.
    if cell["reward"] == "default" and cell["embedding"] == "complex":
        wait *= 2
    if size == 1 and cell["controller"] == "dual-memory":
        wait *= 1.6
    slope = {"exact": 0.9, "simple": 0.5}.get(cell["embedding"], 0.2)
    dual = cell["controller"] == "dual-memory"
    return {
        "wait": wait,
        "arrived": ARRIVED[cell["reward"]],
        "start": 20.0 if dual else 40.0,
        "slope": slope / 2 if dual else slope,
    }


def write_study(
    folder,
    *,
    presets=("matched",),
    scenarios=("grid:1x1", "grid:3x3", "grid:5x5"),
    seeds=8,
    cells=None,
    adjust=None,
    spread=0.01,
):
    """Write a folder of results; ``adjust(cell, scenario, means)`` changes what is expected."""
    cells = list(cells_of_a_study()) if cells is None else cells
    runs, series = [], []
    times = np.arange(0, 301, 10)
    for preset, scenario, cell in product(presets, scenarios, cells):
        means = expected(cell, scenario)
        if adjust:
            adjust(cell, scenario, means)
        spawned = 140 * int(scenario[-1]) - 10
        rng = stream(7, preset, scenario, *map(str, cell.values()))
        # Equal seeds share their demand, so they share most of their luck.
        demand = np.array([stream(seed, scenario).normal(0, 0.2) for seed in range(seeds)])
        wait = means["wait"] * (1 + demand) * (1 + rng.normal(0, spread, seeds))
        arrived = np.round(spawned * means["arrived"] * (1 + demand / 20)).astype(int)
        key = {"preset": preset, "scenario": scenario, **cell}
        series.append(_series(key, times, arrived, means))
        runs.append(_runs(key, wait, arrived, spawned, means))
    write_results(folder, pl.concat(runs), pl.concat(series))
    configuration = {
        "name": "synthetic",
        "seeds": seeds,
        "presets": list(presets),
        "dual_memory": {"short_term_rows": 16, "staged_ratio": 0.5},
    }
    write_manifest(
        folder,
        {
            "configuration": configuration,
            "command": "dmil study --seeds 8",
            "started": "2025-01-01T10:00:00",
            "finished": "2025-01-01T10:01:00",
            "wall_s": 60.0,
        },
    )
    return folder


def _frame(key, count, schema, **columns):
    constant = {name: pl.lit(value, schema[name]) for name, value in key.items()}
    return pl.DataFrame(columns).with_columns(
        **constant, **{n: pl.lit(None, t) for n, t in schema.items() if n not in columns | key}
    )


def _runs(key, wait, arrived, spawned, means):
    seeds = len(wait)
    entries = means["start"] + 30 * means["slope"]
    waiting = wait * arrived * spawned
    columns = {
        "seed": np.arange(seeds),
        "simulator": ["queue"] * seeds,
        "study": ["synthetic"] * seeds,
        "horizon_s": np.full(seeds, 300),
        "spawned_veh": np.full(seeds, spawned),
        "arrived_veh": arrived,
        "wait_veh_s": waiting.astype(int),
        "wait_per_spawned_s": wait * arrived,
        "w_over_vc": wait,
        "mean_queue_veh": waiting / 300,
        "travel_time_s": wait * arrived + 30,
        "throughput_veh_per_h": arrived * 12.0,
        "entries_per_agent": np.full(seeds, entries),
        "entries_total": np.full(seeds, int(entries) * (1 if key["communication"] else 9)),
        "bytes_total": np.full(seeds, int(64 * entries)),
        "messages": np.full(seeds, 100 * key["communication"]),
        "exchanged_bytes": np.full(seeds, 5000 * key["communication"]),
        "msize_per_agent": np.full(seeds, 8 * entries),
        "status": ["ok"] * seeds,
    }
    frame = _frame(key, seeds, RUNS_SCHEMA, **columns)
    return frame.select(pl.col(name).cast(dtype) for name, dtype in RUNS_SCHEMA.items())


def _series(key, times, arrived, means):
    seeds = len(arrived)
    share = (times / times[-1]) ** 1.2
    decisions = np.arange(len(times))
    entries = np.tile(means["start"] + means["slope"] * decisions, seeds)
    dual = key["controller"] == "dual-memory"
    short = np.tile(decisions % 16, seeds) if dual else np.zeros(seeds * len(times))
    columns = {
        "seed": np.repeat(np.arange(seeds), len(times)),
        "simulator": ["queue"] * seeds * len(times),
        "time_s": np.tile(times, seeds),
        "arrived_veh": np.round(np.outer(arrived, share)).astype(int).ravel(),
        "queue_veh": np.tile(10 + decisions, seeds),
        "short_term_entries": short,
        "long_term_entries": entries - short if dual else np.zeros(len(entries)),
        "table_entries": np.zeros(len(entries)) if dual else entries,
        "msize_per_agent": 8 * short + 3 * (entries - short) if dual else 8 * entries,
    }
    frame = _frame(key, len(entries), SERIES_SCHEMA, **columns)
    return frame.select(pl.col(name).cast(dtype) for name, dtype in SERIES_SCHEMA.items())


@pytest.fixture(scope="session")
def make_study(tmp_path_factory):
    """A function that writes a made-up study and returns its folder."""

    def make(name="study", **options):
        return write_study(tmp_path_factory.mktemp("made-up") / name, **options)

    make.cells = cells_of_a_study
    return make


@pytest.fixture(scope="session")
def make_resco_study(tmp_path_factory):
    """A function that writes a made-up study on the RESCO benchmark and returns its folder."""

    def make(name="study", **options):
        return write_resco_study(tmp_path_factory.mktemp("made-up-resco") / name, **options)

    return make


@pytest.fixture(scope="session")
def memories_study(tmp_path_factory):
    """The folder of the whole made-up study of memories, which no test changes."""
    return write_made_up_study(tmp_path_factory.mktemp("memories") / "study")


@pytest.fixture(scope="session")
def made_up_memories(memories_study):
    """The tables of the whole made-up study of memories."""
    with Results(memories_study) as results:
        return memories_tables(results)
