"""What an entry of the catalogue of controllers says."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from pydantic import BaseModel

Value = bool | int | float | str
DIGITS = 4
"""Significant digits of a tuned number: more would only look precise."""


@dataclass(frozen=True, slots=True)
class Range:
    """Numbers from ``low`` to ``high``, both included.

    Parameters
    ----------
    low, high
        The ends.
    log
        Whether equal ratios, not equal steps, are equally likely.
    whole
        Whether they are whole numbers.
    """

    low: float
    high: float
    log: bool = False
    whole: bool = False

    def rounded(self, value: float) -> float:
        """Return a value with few digits, still within the range."""
        if self.whole:
            return int(value)
        return min(max(float(f"{value:.{DIGITS}g}"), self.low), self.high)


@dataclass(frozen=True, slots=True)
class Choice:
    """A few values that have no order."""

    values: tuple[Value, ...]


@dataclass(frozen=True, slots=True)
class Entry:
    """A controller that has a name; its card is docs/controllers/<name>.md.

    Attributes
    ----------
    make
        Its class, or a function that loads it; takes the settings as first argument where it has
        some, and the keyword ``prior`` where it begins from one.
    settings
        Class of its settings, None if it has none.
    summary: str
        One line for people.
    label, short: str
        What reports call it, by default its name; and in tables with much beside it, by default
        its label.
    colour: str
        Its colour in every report, by default grey as rules are; mostly of Okabe and Ito's palette,
        which colour-blind readers tell apart.
    shades: dict
        Embedding, or another option, to the colour of the controller with it.
    dash: tuple of int
        How its lines are dashed: px drawn, px left out.
    ranges: dict
        Option to what `dmil.experiments.tuning` tries of it, None for nothing; other options are
        tried within their limits.
    learns: bool
        Whether it has a memory to train.
    from_prior: bool
        Whether it can begin from what a dummy agent learned.
    online: bool
        Whether it is meant to learn while it works, from the first second on, without training.
    shows_plan: bool
        Whether it shows the network's own signal program, and keeps its times.
    sumo_only: bool
        Whether only SUMO can run it.
    oracle: bool
        Whether it plans one intersection with all arrivals known: a limit, no rival.
    """

    make: Any
    settings: type[BaseModel] | None
    summary: str
    label: str = ""
    short: str = ""
    colour: str = "#9c9c9c"
    shades: Mapping[str, str] = field(default_factory=dict)
    dash: tuple[int, ...] = (1, 0)
    ranges: Mapping[str, Range | Choice | None] = field(default_factory=dict)
    learns: bool = False
    from_prior: bool = False
    online: bool = False
    shows_plan: bool = False
    sumo_only: bool = False
    oracle: bool = False

    @property
    def family(self) -> str:
        """The folder that it lies in."""
        return str(self.make.__module__.split(".")[2])
