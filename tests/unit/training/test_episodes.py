"""What is noted of a training: rows of its episodes, and a log that survives its end."""

import csv
import json
import sys
from types import SimpleNamespace

import pytest

from dmil.controllers import make_controller
from dmil.errors import InputError, MissingExtraError
from dmil.rewards import make_reward
from dmil.scenarios import scenario
from dmil.training import train
from dmil.training.episodes import COLUMNS, WRITERS, EpisodeRecorder, TrainingLog

SCENARIO = scenario("grid:1x2", horizon_s=120)


def trained(*observers, episodes=range(3)):
    controller = make_controller("sarsa", {"epsilon": 0.5, "epsilon_decay": 0.9})
    reward = make_reward("queue")
    return train(SCENARIO, controller, reward, 0, episodes=episodes, observers=observers)


def test_every_episode_is_a_row_with_its_rewards_and_exploration():
    recorder = EpisodeRecorder()
    runs = trained(recorder)
    assert recorder.runs == runs
    assert [row["episode"] for row in recorder.rows] == [0, 1, 2]
    first = recorder.rows[0]
    assert first["decisions"] == 12
    assert first["epsilon"] == pytest.approx(0.5 * 0.9**12)
    assert first["reward_sum"] < 0
    assert first["travel_time_s"] == runs[0].measures.travel_time_s
    assert set(recorder.study_rows()[0]) < set(first)


@pytest.mark.parametrize("ending", [".csv", ".jsonl"])
def test_a_log_goes_on_where_a_policy_was_saved_and_doubles_nothing(tmp_path, ending):
    def rows():
        text = path.read_text(encoding="utf-8").splitlines()
        return list(csv.DictReader(text)) if ending == ".csv" else list(map(json.loads, text))

    path = tmp_path / "logs" / f"training{ending}"
    whole = TrainingLog(path)
    assert rows() == []
    trained(whole)
    before = rows()
    assert [int(row["episode"]) for row in before] == [1, 2, 3]
    assert tuple(before[0]) == COLUMNS
    assert float(before[2]["reward_sum"]) == whole.rows[2]["reward_sum"]
    # The policy after two episodes was the last that was kept.
    trained(TrainingLog(path, done=2), episodes=range(2, 5))
    assert [int(row["episode"]) for row in rows()] == [1, 2, 3, 4, 5]
    assert rows()[:2] == before[:2]
    TrainingLog(path)
    assert rows() == []


def test_a_log_of_another_kind_is_refused(tmp_path):
    with pytest.raises(InputError, match="xlsx"):
        TrainingLog(tmp_path / "log.xlsx")


def test_tensorboard_gets_a_number_of_every_column(tmp_path, monkeypatch):
    written = []

    class SummaryWriter:
        def __init__(self, folder, purge_step):
            written.append((folder, purge_step))

        def add_scalar(self, *found):
            written.append(found)

        def flush(self):
            written.append("flushed")

    stand_in = SimpleNamespace(SummaryWriter=SummaryWriter)
    monkeypatch.setitem(sys.modules, WRITERS[0], stand_in)
    trained(TrainingLog(tmp_path / "board", done=1), episodes=range(1, 2))
    assert written[0] == (str(tmp_path / "board"), 2)
    assert written[-1] == "flushed"
    assert [each[0] for each in written[1:-1]] == [f"training/{name}" for name in COLUMNS[1:]]
    assert {each[2] for each in written[1:-1]} == {2}
    for name in WRITERS:
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(MissingExtraError, match=r"dmil\[tensorboard\]"):
        TrainingLog(tmp_path / "board")
