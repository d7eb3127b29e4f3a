"""Reading JSON files of others, with errors that name the file and the place in it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TypeVar

from pydantic import TypeAdapter, ValidationError

from dmil.errors import InputError

Shape = TypeVar("Shape")


def read_json(
    path: str | Path, shape: TypeAdapter[Shape], *, content: str, error: type[InputError]
) -> Shape:
    """Read a JSON file and check its shape (ours).

    ``content`` says in words what the file should be, such as ``"a CityFlow road network"``.

    Raises
    ------
    InputError
        Of the given kind, if the file is missing, unreadable, cut off, not JSON or of another
        shape.
    """
    text = _text(Path(path), content, error)
    try:
        document = json.loads(text)
    except json.JSONDecodeError as cause:
        where = f"{path}, line {cause.lineno}, column {cause.colno}"
        if cause.pos >= len(text.rstrip()) - 1 or cause.msg.startswith("Unterminated"):
            raise error(
                "the file is cut off in the middle",
                where=where,
                expected=content,
                mend="copy or download it again",
            ) from None
        raise error(
            f"this is not JSON ({cause.msg})",
            where=where,
            expected=content,
            mend="check that this is the right file",
        ) from None
    except (ValueError, RecursionError) as cause:  # a number of 5,000 digits, 10,000 brackets
        raise error(
            f"this is not usable JSON ({cause})", where=str(path), expected=content
        ) from None
    try:
        return shape.validate_python(document)
    except ValidationError as cause:
        place, problem = first_problem(cause)
        raise error(
            problem,
            where=f"{path}: {place}" if place else str(path),
            expected=content,
            mend="check that this is the right file, and correct this place",
        ) from None


def first_problem(cause: ValidationError) -> tuple[str, str]:
    """Turn pydantic's report into a place (``roads[3].lanes[0].maxSpeed``) and a problem (ours)."""
    errors = cause.errors(include_url=False)
    first = errors[0]
    place = ""
    for part in first["loc"]:
        place += f"[{part}]" if isinstance(part, int) else f".{part}" if place else part
    message = str(first["msg"]).removeprefix("Value error, ")
    problem = message[0].lower() + message[1:].replace(" after validation", "")
    problem = problem.replace("tuple", "list")
    if first["type"] in ("model_type", "dict_type"):
        problem = "this is no object {…}"
    if first["type"] == "missing":
        problem = "this field is missing"
    elif first["type"] == "extra_forbidden":
        problem = "there is no such field"
    elif isinstance(first["input"], str | int | float | bool | None):
        problem = f"{problem}, but it is {first['input']!r}"
    if len(errors) > 1:
        problem = f"{problem} (the first of {len(errors)} problems)"
    return place, problem


def _text(path: Path, content: str, error: type[InputError]) -> str:
    try:
        text = path.read_text(encoding="utf-8-sig")  # some editors begin with a mark
    except FileNotFoundError:
        raise error(
            "there is no such file", where=str(path), expected=content, mend="check the path"
        ) from None
    except UnicodeDecodeError:
        raise error(
            "this is not a text file in UTF-8",
            where=str(path),
            expected=content,
            mend="check that this is the right file",
        ) from None
    except OSError as cause:
        raise error(
            f"it cannot be read ({cause.strerror})", where=str(path), expected=content
        ) from None
    if not text.strip():
        raise error(
            "the file is empty",
            where=str(path),
            expected=content,
            mend="copy or download it again",
        )
    return text
