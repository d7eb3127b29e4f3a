"""Recorded runs: what is in their tables."""

import polars as pl

from dmil.controllers import make_controller
from dmil.results.schema import RECORDINGS
from dmil.rewards import make_reward
from dmil.scenarios import scenario
from dmil.simulation import QueueSimulator
from dmil.training import evaluate, vehicles_of_seed
from dmil.training.recording import Recording


def test_the_tables_of_recorded_runs_agree_with_their_measures(tmp_path):
    made = scenario("grid:1x2", horizon_s=120)
    recording, simulator, runs = Recording(made.network), QueueSimulator(made), []
    for seed in (3, 4):
        controller, reward = make_controller("sarsa"), make_reward("queue")
        vehicles = vehicles_of_seed(made, seed)
        runs.append(
            evaluate(simulator, controller, vehicles, reward, seed, observers=recording.observers)
        )
        recording.add(seed, runs[-1])
    found = {}
    for name in recording.tables:
        recording.write(name, tmp_path / f"{name}.parquet")
        found[name] = pl.read_parquet(tmp_path / f"{name}.parquet")
        assert dict(found[name].schema) == RECORDINGS[name].schema
        assert found[name]["seed"].unique().to_list() == [3, 4]
    assert set(found) == set(RECORDINGS) - {"training"}
    seconds, series, flows = found["seconds"], found["series"], found["flows"]
    assert seconds.filter(seed=4)["queue_veh"].to_list() == runs[1].measures.queued_at.tolist()
    assert series.filter(seed=3)["bytes_total"][-1] == runs[0].memory[-1].bytes_total
    assert series.filter(seed=3)["time_s"].to_list() == [*range(0, 121, 10)]
    assert flows.height == 2 * 13 * 2
    waiting = flows.filter(time_s=120, seed=3)["queue_veh"].sum()
    assert waiting == runs[0].measures.queued_at[-1]
    assert found["signals"]["time_s"].is_between(0, 120).all()
