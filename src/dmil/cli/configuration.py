"""Parameters of a command from a TOML file, checked, merged with options, and written as TOML."""

from __future__ import annotations

import json
import re
import textwrap
import tomllib
import types
import typing
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Literal, TypeVar

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from dmil.errors import InputError, unknown_name

Model = TypeVar("Model", bound=BaseModel)
Values = dict[str, Any]

_SHORTER = {
    "greater than or equal to": "at least",
    "less than or equal to": "at most",
    "greater than": "more than",
    "a valid integer": "a whole number",
    "a valid number": "a number",
    "a valid boolean": "true or false",
    "a valid string": "text",
    "Tuple should have": "a list of",
    " item after validation": "",
    "Input is not a valid path for <class 'pathlib.Path'>": "a path",
}


def read_file(path: Path, kind: type[BaseModel]) -> Values:
    """Read a TOML file whose keys are the fields of ``kind``, tables for those that nest.

    An `InputError` if the file cannot be read, is no TOML, or has an unknown key.
    """
    where = str(path)
    try:
        values = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except FileNotFoundError:
        raise InputError(
            "there is no such file", where=where, mend="write one with: dmil … --print-config"
        ) from None
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror})", where=where) from None
    except ValueError as error:  # TOML's and UTF-8's errors are both of this kind
        raise InputError(f"no TOML: {error}", where=where) from None
    _check_keys(values, kind, where)
    return values


def _check_keys(values: Values, kind: type[BaseModel], where: str, table: str = "") -> None:
    if kind.model_config.get("extra") == "allow":
        return
    place = f"{where}, table [{table}]" if table else where
    for key, value in values.items():
        if key not in kind.model_fields:
            raise unknown_name("key", key, kind.model_fields, where=place)
        nested = _nested(kind.model_fields[key])
        tables = value if isinstance(value, list) else [value]
        if nested is not None:
            for each in tables:
                if isinstance(each, dict):
                    _check_keys(each, nested, where, f"{table}.{key}" if table else key)


def _nested(field: FieldInfo) -> type[BaseModel] | None:
    """Return the class of the tables that a field holds, None if it holds plain values."""
    for kind in (field.annotation, *typing.get_args(field.annotation)):
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            return kind
    return None


def with_tables(values: Values, kind: type[BaseModel]) -> Values:
    """Return a file's values with texts that stand for tables as these tables.

    A controller may be given by its name alone; options go over the table, and not in its place.
    """
    tables: Values = {}
    for key, value in values.items():
        nested = _nested(kind.model_fields[key])
        if nested is not None and isinstance(value, str):
            value = nested.model_validate(value).model_dump()
        tables[key] = value
    return tables


def merge(below: Values, above: Mapping[str, Any]) -> Values:
    """Lay values over others, table by table; a table with another name is another thing."""
    if above.get("name", below.get("name")) != below.get("name") and "name" in below:
        return dict(above)
    merged = dict(below)
    for key, value in above.items():
        under = merged.get(key)
        both = isinstance(under, dict) and isinstance(value, Mapping)
        merged[key] = merge(typing.cast(Values, under), value) if both else value
    return merged


def validated(kind: type[Model], values: Values, places: Mapping[str, str], file: str) -> Model:
    """Make settings from values, or an `InputError` naming the first value that cannot be used.

    ``places`` has the path of a field, such as ``timing.clearance_s``, to the option it was given
    by; everything else comes from the file.
    """
    try:
        return kind(**values)
    except ValidationError as error:
        first = error.errors()[0]
    steps = [str(step) for step in first["loc"] if not isinstance(step, int)]
    path = ".".join(steps)
    # The innermost table or value on the way to it that an option has given.
    ways = (".".join(steps[:length]) for length in range(len(steps), 0, -1))
    option = next((places[way] for way in ways if way in places), None)
    if option is None and path and not file:
        option = " and ".join(flag for way, flag in places.items() if way.startswith(f"{path}."))
    where = option or ": ".join(part for part in (file, path) if part)
    if first["type"] == "literal_error":
        known = list(_literals(field_at(kind, path).annotation))
        raise unknown_name(steps[-1].removesuffix("s"), str(first["input"]), known, where=where)
    if not steps:
        # A check of several values names them itself; the input would be all there is.
        problem = _expected(first["msg"])
        named = [
            flag
            for given, flag in places.items()
            if re.search(rf"(?<![\w.]){re.escape(given)} (is|\()", problem)
        ]
        raise InputError(problem, where=" and ".join(named) or file or "settings")
    raise InputError(
        f"found {_shown(first['input'])}", where=where, expected=_expected(first["msg"])
    )


def _expected(message: str) -> str:
    """Say pydantic's sentence more shortly."""
    for start in ("Value error, ", "Input should be "):
        message = message.removeprefix(start)
    message = re.sub(r"a valid dictionary or instance of \w+", "a table", message)
    for long, short in _SHORTER.items():
        message = message.replace(long, short)
    return message


def _literals(annotation: Any) -> Iterator[str]:
    if typing.get_origin(annotation) is Literal:
        yield from map(str, typing.get_args(annotation))
        return
    for part in typing.get_args(annotation):
        yield from _literals(part)


def _shown(value: Any) -> str:
    return repr(value) if isinstance(value, str) else str(value)


def as_toml(settings: BaseModel, title: str) -> str:
    """Write settings as TOML below a title, every key with its meaning; unset ones commented."""
    lines = [f"# {title}", *_table(settings, "")]
    return "\n".join(lines) + "\n"


def _table(settings: BaseModel, name: str) -> Iterator[str]:
    tables: list[tuple[str, BaseModel, str]] = []
    for key, field in type(settings).model_fields.items():
        value = getattr(settings, key)
        path = f"{name}.{key}" if name else key
        if isinstance(value, BaseModel):
            tables.append((f"[{path}]", value, field.description or ""))
        elif _nested(field) is not None and isinstance(value, tuple):
            tables += [(f"[[{path}]]", each, field.description or "") for each in value]
        else:
            yield from ("", *_comment(field.description or ""), pair(key, value))
    meanings = getattr(settings, "meanings", {})
    for key, value in (settings.model_extra or {}).items():
        yield from ("", *_comment(meanings.get(key, "")), pair(key, value))
    for head, each, meaning in tables:
        yield from ("", *_comment(meaning), head, *_table(each, head.strip("[]")))


def _comment(text: str) -> list[str]:
    lines = textwrap.wrap(text, 98, break_long_words=False, break_on_hyphens=False)
    return [f"# {line}" for line in lines]


def pair(key: str, value: Any) -> str:
    """Return a key with its value as TOML, a comment if it has none."""
    if value is None:
        return f"# {key} ="
    return f"{key} = {toml_value(value)}"


def _key(key: object) -> str:
    """Return a key as TOML writes it: names of nodes may hold anything."""
    text = str(key)
    return text if re.fullmatch(r"[A-Za-z0-9_-]+", text) else toml_value(text)


def toml_value(value: Any) -> str:
    """Return a value as TOML writes it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        return repr(value)
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(toml_value, value))}]"
    if isinstance(value, dict):
        return "{ " + ", ".join(pair(_key(key), each) for key, each in value.items()) + " }"
    # A JSON string is a TOML string, too.
    return json.dumps(str(value), ensure_ascii=False)


def base_type(annotation: Any) -> Any:
    """Return T of ``T | None``, other annotations as they are."""
    if typing.get_origin(annotation) in (typing.Union, types.UnionType):
        inner = [part for part in typing.get_args(annotation) if part is not type(None)]
        return base_type(inner[0]) if len(inner) == 1 else annotation
    if typing.get_origin(annotation) is typing.Annotated:
        return base_type(typing.get_args(annotation)[0])
    return annotation


def field_at(kind: type[BaseModel], path: str) -> FieldInfo:
    """Return the field at a dotted path."""
    name, _, rest = path.partition(".")
    field = kind.model_fields[name]
    nested = _nested(field)
    return field_at(nested, rest) if rest and nested is not None else field


def checked_field(kind: type[BaseModel], path: str, *, where: str, above: str = "") -> FieldInfo:
    """Return the field at a dotted path that a user gave to an option.

    ``above`` is the path of the table that ``kind`` is. An `InputError` if there is no such field,
    or the path goes on behind a value or stops at a table.
    """
    name, _, rest = path.partition(".")
    if kind.model_config.get("extra") == "allow" and name not in kind.model_fields and not rest:
        return FieldInfo()
    here = f"{above}.{name}" if above else name
    if name not in kind.model_fields:
        place = f"{where}, table [{above}]" if above else where
        raise unknown_name("key", name, kind.model_fields, where=place)
    field = kind.model_fields[name]
    nested = None if isinstance(field.default, tuple) else _nested(field)
    if rest and nested is None:
        raise InputError(
            f"'{here}' is no table", where=where, expected=f"{here}=VALUE, the whole of it"
        )
    if nested is None or rest:
        return checked_field(nested, rest, where=where, above=here) if nested else field
    first = next(iter(nested.model_fields))
    raise InputError(
        f"'{here}' is a table", where=where, expected=f"one of its values, such as {here}.{first}=…"
    )


def without(values: Values, path: str) -> Values:
    """Return values without what stands at a dotted path."""
    name, _, rest = path.partition(".")
    if rest and isinstance(values.get(name), dict):
        return values | {name: without(values[name], rest)}
    return {key: value for key, value in values.items() if rest or key != name}


def nested_value(path: str, value: Any) -> Values:
    """Return ``{"a": {"b": value}}`` for the path "a.b"."""
    name, _, rest = path.partition(".")
    return {name: nested_value(rest, value) if rest else value}
