import json

import pytest

from dmil.errors import InputError
from dmil.experiments.tuning import Tuned, TuningSettings, load_tuned, load_tuned_folder
from dmil.experiments.tuning.record import TrialRecord, save_tuned
from dmil.importing import only

SETTINGS = TuningSettings(check_seeds=2).model_dump(mode="json")


def made(values=None, **changes):
    scores = [float(number) for number in range(20)]
    trials = (
        TrialRecord(values={}, state="finished", mean=8.5, scores=scores),
        TrialRecord(values=values or {"green_s": 21.5}, state="finished", mean=7.5, scores=scores),
    )
    fields = {
        "dmil": "0",
        "controller": "fixed-cycle",
        "fixed": {},
        "chosen": {"green_s": 21.5},
        "scenario": "grid:1x1",
        "recipe": {},
        "same_demand": False,
        "simulator": "queue",
        "reward": "queue",
        "horizon_s": 100,
        "settings": SETTINGS,
        "space": {"green_s": {"low": 10, "high": 60, "log": False, "whole": False}},
        "finished": True,
        "runs": 40,
        "trials": trials,
        "best": 1,
    }
    return Tuned(**(fields | changes))


def test_what_is_written_is_read_again_and_people_can_read_it(tmp_path):
    path = tmp_path / "fixed-cycle.json"
    save_tuned(made(), path)
    assert load_tuned(path) == made()
    text = path.read_text()
    assert '\n  "chosen": {\n    "green_s": 21.5\n  },' in text
    assert max(map(len, text.splitlines())) < 400


def test_a_folder_gives_the_options_of_every_controller(tmp_path):
    save_tuned(made(), tmp_path / "a.json")
    fixed = {"fixed": {"approaching": True}, "chosen": {"approaching": True, "hysteresis": 1.0}}
    tuned = made({"hysteresis": 1.0}, controller="max-pressure", **fixed)
    save_tuned(tuned, tmp_path / "b.json")
    found = load_tuned_folder(tmp_path)
    assert {each.label: each.chosen for each in found} == {
        "fixed-cycle": {"green_s": 21.5},
        "max-pressure,approaching=true": {"approaching": True, "hysteresis": 1.0},
    }


def test_a_controller_of_ones_own_has_nothing_to_tune_and_is_read(tmp_path):
    own = made(controller="mine:Own", chosen={}, space={}, trials=(), best=0, runs=0)
    save_tuned(own, tmp_path / "a.json")
    with pytest.raises(InputError, match="it names the controller 'mine:Own'"):
        load_tuned(tmp_path / "a.json")
    with only(["mine:Own"]):
        assert load_tuned(tmp_path / "a.json") == own


def test_the_summary_says_where_with_the_load():
    assert made().summary()["scenario"] == "grid:1x1"
    assert made(recipe={"load": 1.0}).summary()["scenario"] == "grid:1x1"
    assert made(recipe={"load": 2.5}).summary()["scenario"] == "grid:1x1*2.5"


def test_a_folder_without_any_is_told(tmp_path):
    for folder in (tmp_path, tmp_path / "nowhere"):
        with pytest.raises(InputError, match="no tuned controller is there"):
            load_tuned_folder(folder)


def test_one_that_cannot_be_read_is_told(tmp_path):
    with pytest.raises(InputError, match="there is no such file"):
        load_tuned(tmp_path / "none.json")
    with pytest.raises(InputError, match="cannot be read"):
        load_tuned(tmp_path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"format": "other"}, "no tuned controller"),
        ({"version": 2}, "version 2 of the format, written by dmil 0; expected version 1"),
        ({"finished": False}, "did not come to its end"),
        ({"controller": "fixd-cycle"}, "no controller named 'fixd-cycle'"),
        ({"chosen": {"gren_s": 20}}, "Did you mean 'green_s'"),
        ({"chosen": {"green_s": -1}}, "green_s = -1; expected greater than 0"),
        ({"chosen": 3}, "damaged: chosen"),
        ({"chosen": {}}, "damaged: what is chosen is not its best trial"),
        ({"chosen": {"green_s": 22.0}}, "damaged: what is chosen is not its best trial"),
        ({"best": 2}, "damaged: what is chosen is not its best trial"),
        ({"more": 3}, "damaged: more"),
        ({"settings": {}}, "damaged: 'seeds'"),
        ({"trials": [{"values": {}, "scores": [1.0]}]}, "1 scores in place of 20"),
    ],
)
def test_what_is_wrong_with_a_file_is_told(change, message, tmp_path):
    path = tmp_path / "fixed-cycle.json"
    save_tuned(made(), path)
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    with pytest.raises(InputError, match=message):
        load_tuned(path)


@pytest.mark.parametrize("text", ["", "[1]", '{"format": "dmil-tuned"'])
def test_a_damaged_file_is_told(text, tmp_path):
    path = tmp_path / "a.json"
    path.write_text(text)
    with pytest.raises(InputError, match=r"damaged|no tuned controller"):
        load_tuned(path)
