"""Reading JSON files of others, with errors that name the file and the place in it."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from typing import TypeVar

from pydantic import TypeAdapter, ValidationError

from dmil.errors import InputError

Shape = TypeVar("Shape")
_AGAIN, _CHECK = "copy or download it again", "check that this is the right file"


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
    wrong = partial(error, expected=content)
    try:
        document = json.loads(text)
    except json.JSONDecodeError as cause:
        where = f"{path}, line {cause.lineno}, column {cause.colno}"
        if cause.pos >= len(text.rstrip()) - 1 or cause.msg.startswith("Unterminated"):
            raise wrong("the file is cut off in the middle", where=where, mend=_AGAIN) from None
        raise wrong(f"this is not JSON ({cause.msg})", where=where, mend=_CHECK) from None
    except (ValueError, RecursionError) as cause:  # a number of 5,000 digits, 10,000 brackets
        raise wrong(f"this is not usable JSON ({cause})", where=str(path)) from None
    try:
        return shape.validate_python(document)
    except ValidationError as cause:
        place, problem = first_problem(cause)
        where = f"{path}: {place}" if place else str(path)
        raise wrong(problem, where=where, mend=f"{_CHECK}, and correct this place") from None


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
    wrong = partial(error, where=str(path), expected=content)
    try:
        text = path.read_text(encoding="utf-8-sig")  # some editors begin with a mark
    except FileNotFoundError:
        raise wrong("there is no such file", mend="check the path") from None
    except UnicodeDecodeError:
        raise wrong("this is not a text file in UTF-8", mend=_CHECK) from None
    except OSError as cause:
        raise wrong(f"it cannot be read ({cause.strerror})") from None
    if not text.strip():
        raise wrong("the file is empty", mend=_AGAIN)
    return text
