"""The flat public namespace."""

import importlib

import pytest

import dmil


@pytest.mark.parametrize("name", dmil.__all__)
def test_every_public_name_is_the_one_of_its_room(name):
    room = next(room for room, names in dmil._ROOMS.items() if name in names)
    assert getattr(dmil, name) is getattr(importlib.import_module(f"dmil.{room}"), name)
    assert name in dir(dmil)


def test_a_name_that_does_not_exist_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'nothing_of_this_name'"):
        dmil.nothing_of_this_name  # noqa: B018
