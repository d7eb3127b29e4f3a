"""A study of memories with numbers that were made up, so that every table has something to say."""

from pathlib import Path

import numpy as np
import polars as pl

from dmil.results import TABLES, write_manifest, write_results

CELLS = (
    ("grid:1x1", 1.0),
    ("grid:1x1", 3.0),
    ("grid:1x1", 7.0),
    ("grid:3x3", 1.0),
    ("grid:3x3", 4.0),
    ("grid:5x5", 1.0),
    ("grid:5x5", 3.0),
    ("grid:5x5", 3.6),
    ("grid:5x5/unequal", 1.0),
    ("grid:5x5/time-varying", 1.0),
    ("cityflow:hangzhou_4x4", 1.0),
    ("cityflow:jinan_3x4", 1.0),
    ("cityflow:jinan_3x4#real_2000.json", 1.0),
)
#: Controller to the ratio of its W to max-pressure's, its bytes per intersection, whether it is
#: trained (None: it does not learn).
CONTROLLERS: dict[str, tuple[float, int, bool | None]] = {
    "random": (6.5, 0, None),
    "webster": (2.1, 0, None),
    "longest-queue-first": (0.93, 0, None),
    "longest-queue-first,approaching=true": (0.89, 0, None),
    "max-pressure": (1.0, 0, None),
    "foresight": (0.8, 0, None),
    "sarsa,epsilon=0.05": (6.6, 160_000, True),
    "sarsa,embedding=complex,epsilon=0.05": (3.4, 9_000, True),
    "dual-memory,epsilon=0.05": (3.3, 6_500, True),
    "mfec": (1.9, 1_200_000, True),
    "plmp": (2.4, 90_000, True),
    "dqn": (1.5, 450_000, True),
    "dqn-prioritised": (1.4, 610_000, True),
    "vdn": (1.35, 470_000, True),
    "factored": (0.82, 3_400, False),
    "lookahead": (0.84, 1_900, False),
    "factored,prior=false": (0.87, 3_400, False),
}
ABLATIONS = ("factored,prior=false",)
DIVERGED = ("vdn", "grid:5x5", 3.6, 2)
HORIZON_S = 3600
EPISODES = 4

TUNING = {
    "controller": "mfec",
    "scenario": "grid:3x3",
    "metric": "delay_s",
    "budget_runs": 2000,
    "runs": 1991,
    "rungs": [{"seeds": 2, "candidates": 57}, {"seeds": 6, "candidates": 20}],
    "chosen": {"neighbours": 7},
    "defaults_kept": False,
    "default_mean": 31.41,
    "best_mean": 27.18,
    "best_over_default_minus_1": {"mean": -0.135, "low": -0.21, "high": -0.08},
}


def write_made_up_study(
    folder: Path, *, seeds: int = 6, cells=CELLS, controllers=tuple(CONTROLLERS)
) -> Path:
    """Write the study, in which one run of VDN diverged, and return its folder."""
    tables: dict[str, list[dict]] = {name: [] for name in TABLES}
    for where, (scenario, load) in enumerate(cells):
        for seed in range(seeds):
            rng = np.random.default_rng([where, seed])
            base = 10.0 * (1 + where % 4) * rng.uniform(0.9, 1.1)
            for controller in controllers:
                if controller == "foresight" and not scenario.startswith("grid:1x1"):
                    continue
                key = {
                    "preset": "memories",
                    "scenario": scenario,
                    "load": load,
                    "seed": seed,
                    "controller": controller,
                    "communication": False,
                    "reward": None if CONTROLLERS[controller][2] is None else "queue",
                    "simulator": "queue",
                }
                _run(tables, key, CONTROLLERS[controller], base, rng)
    write_results(
        folder, *(pl.DataFrame(tables[name], each.schema) for name, each in TABLES.items())
    )
    configuration = {
        "controllers": list(controllers),
        "ablations": list(ABLATIONS),
        "episodes": EPISODES,
        "tuned": {"mfec": {"neighbours": 7}},
        "tuning": [TUNING],
    }
    times = {"started": "2026-01-01T00:00:00", "finished": "2026-01-01T00:10:00", "wall_s": 600.0}
    write_manifest(folder, {"study": "memories", "configuration": configuration} | times)
    return folder


def _run(tables, key, numbers, base, rng):
    ratio, size, trained = numbers
    wait = base * ratio * rng.uniform(0.98, 1.02) if ratio != 1.0 else base
    row = key | {
        "study": "memories",
        "horizon_s": HORIZON_S,
        "intersections": 25,
        "training_s": EPISODES * HORIZON_S if trained else None,
    }
    place = key["controller"], key["scenario"], key["load"], key["seed"]
    if place == DIVERGED:
        tables["runs"].append(row | {"status": "DivergedError: values are not finite at 70 s"})
        return
    tables["runs"].append(
        row
        | {
            "wait_per_spawned_s": wait,
            "delay_s": wait + 2,
            "travel_time_s": wait + 40,
            "mean_queue_veh": wait * 3,
            "throughput_veh_per_h": 2000.0,
            "entries_per_agent": size / 100,
            "entries_total": size // 100,
            "bytes_total": size * 25,
            "decisions_until_better": 0 if trained is False else None,
            "status": "ok",
        }
    )
    for time_s in range(0, HORIZON_S + 1, 600):
        grown = int(size * 25 * (0.5 + 0.5 * time_s / HORIZON_S))
        tables["series"].append(
            key | {"time_s": time_s, "queue_veh": int(wait), "bytes_total": grown}
        )
    for episode in range(EPISODES if trained else 0):
        tables["episodes"].append(
            key
            | {
                "trained_in": "queue",
                "episode": episode,
                "wait_per_spawned_s": wait * (1 + 2 / (1 + episode)),
                "bytes_total": int(size * 25 * (episode + 1) / (EPISODES + 1)),
            }
        )
    if key["controller"].startswith("factored"):
        for source, count in (("long-term", 90), ("prior", 10)):
            tables["lookups"].append(key | {"source": source, "lookups": count})
    tables["timings"].append(key | {"decisions": 360, "decide_s": 0.0001 * (1 + ratio)})
