import pytest

from dmil.controllers.variants import Variant, parse_variant
from dmil.errors import InputError


@pytest.mark.parametrize(
    ("text", "name", "options"),
    [
        ("sarsa", "sarsa", {}),
        ("sarsa,epsilon=0.2", "sarsa", {"epsilon": 0.2}),
        (
            " sarsa , embedding = cells , shared=true",
            "sarsa",
            {"embedding": "cells", "shared": True},
        ),
        ("mine.py:Mine,period=30", "mine.py:Mine", {"period": 30}),
        ("mine:Mine,weights=[1, 2],name=a", "mine:Mine", {"weights": [1, 2], "name": "a"}),
        ('mine:Mine,name="7"', "mine:Mine", {"name": "7"}),
    ],
)
def test_name_and_options_are_read_and_written_again(text, name, options):
    found = parse_variant(text)
    assert (found.name, found.options) == (name, options)
    assert parse_variant(found.label) == found


def test_the_label_is_short():
    assert Variant("max-pressure").label == "max-pressure"
    label = Variant("max-pressure", {"approaching": True, "hysteresis": 1.5}).label
    assert label == "max-pressure,approaching=true,hysteresis=1.5"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "found ''; expected NAME"),
        ("epsilon=0.2", "expected NAME"),
        ("max-pressure,approaching", "expected NAME or NAME,option=value"),
        ("max-pressure,approaching=", "found 'approaching='; expected option=value"),
        ("sarsa,epsilon=0.1,epsilon=0.2", "'epsilon' is given twice"),
    ],
)
def test_what_cannot_be_read_is_told(text, message):
    with pytest.raises(InputError, match=message):
        parse_variant(text)
