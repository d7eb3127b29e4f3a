"""What an interpretation of the paper is."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

Mark = Literal["P", "A", "F", "corrected", "ours"]

MEANING: dict[Mark, str] = {
    "P": "stated",
    "A": "assumed",
    "F": "fitted",
    "corrected": "corrected",
    "ours": "ours",
}
"""What a mark says, in a word."""


@dataclass(frozen=True, slots=True)
class Interpretation:
    """One choice, beside what the paper says of it.

    Attributes
    ----------
    topic: str
        Part of the system.
    what: str
        What is chosen.
    paper: str
        What the paper says; words of its own stand in quotation marks.
    here: str
        What we do by default.
    mark: str
        Where that comes from.
    setting: str
        Dotted name of the field that holds it, as in a study's configuration; empty if it is built
        in or more than one field.
    change: str
        How it is changed, by default ``--set`` with the setting; empty if it is built in.
    """

    topic: str
    what: str
    paper: str
    here: str
    mark: Mark
    setting: str = ""
    change: str = ""


OPEN = "not mentioned"


def on(topic: str, *rows: tuple[str, ...]) -> tuple[Interpretation, ...]:
    """Return rows of one topic, each with the fields of `Interpretation` after it (ours)."""
    found = (Interpretation(topic, *row) for row in rows)  # type: ignore[arg-type]
    return tuple(
        replace(each, change=each.change or (each.setting and f"--set {each.setting}=…"))
        for each in found
    )
