"""Parameters from files: checked, merged, written."""

import tomllib
from typing import Literal

import pytest
from pydantic import BaseModel, Field

from dmil.cli.configuration import as_toml, merge, nested_value, pair, read_file, validated
from dmil.errors import InputError, UnknownNameError


class Inner(BaseModel):
    size: int = Field(3, ge=1, description="How large.")
    kind: Literal["red", "blue"] = Field("red", description="Which colour.")


class Free(BaseModel, extra="allow"):
    name: str = Field("a", description="Which.")


class Outer(BaseModel, extra="forbid"):
    seeds: int = Field(5, ge=1, description="How many.")
    out: str | None = Field(None, description="Where to.")
    names: tuple[Literal["one", "two"], ...] = Field(("one",), description="Which ones.")
    inner: Inner = Field(Inner(), description="A table.")
    free: Free = Field(Free(), description="A table of any keys.")
    many: tuple[Free, ...] = Field((), description="Several tables.")


def write(path, text):
    file = path / "file.toml"
    file.write_text(text)
    return file


def test_what_is_written_is_read_again(tmp_path):
    made = Outer(
        seeds=7,
        names=("two", "one"),
        inner=Inner(size=9),
        free=Free(name='a "b"', more=0.5, flag=True),
        many=(Free(name="x"), Free(name="y", list=[1, 2])),
    )
    text = as_toml(made, "title")
    assert text.startswith("# title\n")
    for field in Outer.model_fields.values():
        assert f"# {field.description}" in text
    assert "# out =" in text
    values = read_file(write(tmp_path, text), Outer)
    assert Outer(**values) == made


def test_a_pair_is_toml():
    assert tomllib.loads(pair("a", {"b": [True, "c\n"], "d": 1e-9})) == {
        "a": {"b": [True, "c\n"], "d": 1e-9}
    }


@pytest.mark.parametrize(
    "text, said",
    [
        ("seedz = 3", "there is no key named 'seedz'; expected one of .* Did you mean 'seeds'?"),
        ("[inner]\nsise = 3", r"file.toml, table \[inner\]: there is no key named 'sise'"),
        ("seeds = ", "file.toml: no TOML: Invalid value"),
        ("seeds = 1\nseeds = 2", "file.toml: no TOML: Cannot overwrite"),
    ],
)
def test_a_wrong_file_is_one_error(text, said, tmp_path):
    with pytest.raises(InputError, match=said):
        read_file(write(tmp_path, text), Outer)


def test_a_file_must_be_text(tmp_path):
    (tmp_path / "file.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match=r"file.toml: no TOML"):
        read_file(tmp_path / "file.toml", Outer)
    with pytest.raises(InputError, match="there is no such file"):
        read_file(tmp_path / "no.toml", Outer)
    with pytest.raises(InputError, match="cannot be read"):
        read_file(tmp_path, Outer)


def test_a_table_takes_any_keys_if_it_may(tmp_path):
    assert read_file(write(tmp_path, "[free]\nx = 1"), Outer) == {"free": {"x": 1}}


def test_merging_goes_key_by_key():
    below = {"a": 1, "t": {"x": 1, "y": {"z": 2}}}
    assert merge(below, {"t": {"y": {"w": 3}}, "b": 4}) == {
        "a": 1,
        "b": 4,
        "t": {"x": 1, "y": {"z": 2, "w": 3}},
    }
    assert below == {"a": 1, "t": {"x": 1, "y": {"z": 2}}}


def test_a_table_with_another_name_is_another_thing():
    below = {"controller": {"name": "sarsa", "shared": True}}
    assert merge(below, {"controller": {"name": "random"}}) == {"controller": {"name": "random"}}
    assert merge(below, {"controller": {"name": "sarsa", "epsilon": 0}}) == {
        "controller": {"name": "sarsa", "shared": True, "epsilon": 0}
    }
    assert merge(below, {"controller": {"epsilon": 0}})["controller"]["shared"] is True


@pytest.mark.parametrize(
    "values, places, said",
    [
        ({"seeds": 0}, {"seeds": "--seeds"}, "^--seeds: found 0; expected at least 1.$"),
        ({"seeds": 0}, {}, "^file.toml: seeds: found 0; expected at least 1.$"),
        (
            {"inner": {"size": "x"}},
            {},
            "^file.toml: inner.size: found 'x'; expected a whole number",
        ),
        ({"inner": {"size": 0}}, {"inner.size": "--size"}, "^--size: found 0"),
    ],
)
def test_a_wrong_value_says_where_it_comes_from(values, places, said):
    with pytest.raises(InputError, match=said):
        validated(Outer, values, places, "file.toml")


@pytest.mark.parametrize(
    "values, said",
    [
        ({"names": ["one", "twu"]}, "no name named 'twu'.* Did you mean 'two'"),
        ({"inner": {"kind": "bleu"}}, "no kind named 'bleu'; expected one of blue, red"),
    ],
)
def test_a_wrong_choice_suggests_the_nearest(values, said):
    with pytest.raises(UnknownNameError, match=said):
        validated(Outer, values, {}, "")


def test_a_path_becomes_tables():
    assert nested_value("a.b.c", 1) == {"a": {"b": {"c": 1}}}
