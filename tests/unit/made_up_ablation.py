"""A made-up ablation with known answers, in the shape of a real one."""

import polars as pl

from dmil.results import RUNS_SCHEMA, TABLES, write_manifest, write_results
from dmil.studies.ablation import AblationStudy, AblationStudySettings
from dmil.studies.ablation.plan import units, variants

CELLS = ("grid:3x3*2", "resco/cologne1")
DELAY_S = {"combined": 20.0, "factored": 25.0}
CHANGE_S = {
    "combined,learning=false": 2.0,
    "combined,age=0.0": -1.0,
    "factored,yields=true": -5.0,
}
"""What variants change; all others change nothing."""
SETTINGS = AblationStudySettings(cells=CELLS, controllers=tuple(DELAY_S), seeds=8, first_seed=600)


def write_ablation(folder, *, settings=SETTINGS, failed=(), locked=()):
    """Write a folder of results; ``failed`` and ``locked`` hold (label, scenario, seed)."""
    rows = []
    for unit in units(settings):
        for variant in variants(settings):
            label = variant.label
            key = label, unit.scenario, unit.seed
            row = {
                "study": "ablation",
                "preset": unit.preset,
                "scenario": unit.scenario,
                "load": unit.load,
                "seed": unit.seed,
                "controller": label,
                "communication": False,
                "simulator": "sumo" if unit.scenario.startswith("resco/") else "queue",
                "horizon_s": 3600,
                "status": "ValueError: no" if key in failed else "ok",
            }
            if key not in failed:
                chance = 0.1 * (unit.seed % 3) if label in CHANGE_S else 0.0
                row["delay_s"] = DELAY_S[variant.name] + unit.seed % 5
                row["delay_s"] += CHANGE_S.get(label, 0.0) + chance
                row["delay_s"] += 1000.0 * (key in locked)
                row["locked"] = int(key in locked)
                row["locked_from_s"] = 1200 if key in locked else None
            rows.append(row)
    others = {name: table.schema for name, table in TABLES.items() if name != "runs"}
    empty = (pl.DataFrame(schema=schema) for schema in others.values())
    write_results(folder, pl.DataFrame(rows, schema=RUNS_SCHEMA), *empty)
    configuration = AblationStudy(settings).configuration()
    write_manifest(
        folder, {"study": "ablation", "configuration": configuration, "started": "", "finished": ""}
    )
    return folder
