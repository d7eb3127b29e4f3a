"""The numbers of a kernel, filled from settings."""

from typing import NamedTuple

import pytest
from pydantic import BaseModel

from dmil.controllers.parameters import parameters_of


class Settings(BaseModel):
    speed: float = 1
    steps: int = 2
    colour: str = "red"


class Numbers(NamedTuple):
    steps: int
    speed: float
    length: float


def test_fields_are_settings_by_name_and_what_is_derived():
    assert parameters_of(Numbers, Settings(steps=5), length=3.0) == Numbers(5, 1.0, 3.0)


def test_what_is_derived_goes_before_a_setting_of_that_name():
    assert parameters_of(Numbers, Settings(), length=3.0, speed=0.0).speed == 0.0


def test_a_field_that_nobody_fills_and_a_number_without_a_field_are_mistakes():
    with pytest.raises(AttributeError, match="length"):
        parameters_of(Numbers, Settings())
    with pytest.raises(TypeError, match="width"):
        parameters_of(Numbers, Settings(), length=3.0, width=1.0)
