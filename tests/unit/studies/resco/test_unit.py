"""Units of the study on the RESCO benchmark: one recorded day, or other days like it."""

import pytest

from dmil.studies.resco.plan import ContenderUnit
from dmil.studies.resco.settings import RescoStudySettings
from dmil.studies.resco.study import run_unit

pytest.importorskip("libsumo", reason="needs the extra sumo")


def rows(tmp_path, *, resample):
    settings = RescoStudySettings(
        scenarios=("cologne1",), horizon_s=600, calibrate=False, resample=resample
    )
    found = []
    for seed in (0, 1):
        unit = ContenderUnit("resco", "resco/cologne1", seed, "longest-queue-first")
        (row,) = (
            each
            for each in run_unit(settings, str(tmp_path), unit).runs
            if each["simulator"] == "queue"
        )
        assert row["status"] == "ok"
        found.append(row)
    return found


def test_every_seed_of_the_benchmark_has_the_same_day(tmp_path):
    first, second = rows(tmp_path, resample=False)
    assert first["wait_veh_s"] == second["wait_veh_s"]


def test_resampled_days_differ_and_have_as_many_vehicles(tmp_path):
    first, second = rows(tmp_path, resample=True)
    assert first["wait_veh_s"] != second["wait_veh_s"]
    recorded = rows(tmp_path, resample=False)[0]["spawned_veh"]
    assert first["spawned_veh"] == second["spawned_veh"] == recorded
