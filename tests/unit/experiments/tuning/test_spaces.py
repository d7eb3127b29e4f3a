from typing import Literal

import pytest
from pydantic import BaseModel, Field

from dmil.controllers import CONTROLLERS, make_settings
from dmil.controllers.entry import Entry
from dmil.experiments.tuning.spaces import (
    NOT_TUNED,
    RANGES,
    Choice,
    Range,
    defaults,
    search_space,
)


@pytest.mark.parametrize("name", CONTROLLERS)
def test_a_controller_accepts_every_value_of_its_space(name):
    space = search_space(name)
    for option, values in space.items():
        if isinstance(values, Choice):
            tried = values.values
        else:
            ends = (values.low, values.high, (values.low + values.high) / 2)
            tried = [values.rounded(each) for each in ends]
            assert values.low < values.high and (values.low > 0 or not values.log)
        for value in tried:
            settings = make_settings(CONTROLLERS[name].settings, {option: value}, where=name)
            assert getattr(settings, option) == value


def test_what_makes_another_controller_is_not_tuned():
    for name in CONTROLLERS:
        assert not NOT_TUNED & search_space(name).keys()


def test_no_line_of_the_tables_is_for_nothing():
    fields = {
        name: set(entry.settings.model_fields) if entry.settings else set()
        for name, entry in CONTROLLERS.items()
    }
    assert RANGES.keys() | NOT_TUNED <= set().union(*fields.values())
    for name, entry in CONTROLLERS.items():
        assert entry.ranges.keys() <= fields[name]


def test_options_that_are_set_are_left_out():
    space = search_space("sarsa", {"epsilon": 0.05})
    assert "epsilon" not in space and "learning_rate" in space
    assert search_space("random") == search_space("mine:Mine") == {}


def test_defaults_are_those_of_the_settings():
    space = search_space("dual-memory")
    usual = defaults("dual-memory", space)
    assert usual.keys() == space.keys()
    assert usual["short_capacity"] == 16


class Made(BaseModel):
    fast: bool = False
    mode: Literal["a", "b"] = "a"
    share: float = Field(0.5, ge=0, le=1)
    count: int = Field(3, ge=1, le=9)
    half_open: float = Field(0.5, gt=0, le=1)
    endless: int = Field(3, ge=1)
    name: str = "x"
    learning_rate: float = 0.1


def test_limits_switches_and_choices_are_derived(monkeypatch):
    monkeypatch.setitem(CONTROLLERS, "made", Entry(None, Made, ""))
    assert search_space("made") == {
        "fast": Choice((False, True)),
        "mode": Choice(("a", "b")),
        "share": Range(0, 1),
        "count": Range(1, 9, whole=True),
        "learning_rate": RANGES["learning_rate"],
    }
    own = {"share": None, "endless": Range(1, 5, whole=True)}
    monkeypatch.setitem(CONTROLLERS, "made", Entry(None, Made, "", ranges=own))
    space = search_space("made")
    assert "share" not in space and space["endless"] == Range(1, 5, whole=True)


def test_numbers_are_rounded_within_their_range():
    assert Range(0.0, 1.0).rounded(0.123456) == 0.1235
    assert Range(0.0, 2 / 3).rounded(2 / 3) == 2 / 3
    rounded = Range(1, 9, whole=True).rounded(4)
    assert rounded == 4 and isinstance(rounded, int)
