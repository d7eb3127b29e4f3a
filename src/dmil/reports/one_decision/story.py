"""What the sections of the page share: a decision of a trace, names, numbers and tables."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from textwrap import fill

import numpy as np
import numpy.typing as npt

from dmil.reports.one_decision.trace import Decision, Trace

IntArray = npt.NDArray[np.int32]

SIDES = ("East", "North", "West", "South")
TURNS = ("right", "straight", "left")


def decimal(value: float, digits: int = 3) -> str:
    """Return a number with so many decimals and a true minus sign; nothing is shown as −0."""
    return f"{round(value, digits) + 0.0:.{digits}f}".replace("-", "−")


def subtracted(value: float, digits: int = 3) -> str:
    """Return a number as it stands behind a minus sign: in brackets if it is negative."""
    text = decimal(value, digits)
    return f"({text})" if text.startswith("−") else text


def plain(value: float) -> str:
    """Return a number as short as it can be, with a true minus sign."""
    return f"{value:g}".replace("-", "−")


def by_side(counts: IntArray) -> list[str]:
    """Return the counts of each side, right, straight and left, as one text per side."""
    return [" ".join(plain(count) for count in side) for side in np.split(counts, len(SIDES))]


def line(counts: IntArray) -> str:
    """Return the counts of all movements, sides separated, as code."""
    return f"`{' · '.join(by_side(counts))}`"


def table(heads: Sequence[object], rows: Iterable[Sequence[object]]) -> str:
    """Return a table in markdown."""
    lines = (heads, ["-"] * len(heads), *rows)
    return "\n".join(f"| {' | '.join(map(str, cells))} |" for cells in lines)


def wrapped(text: str) -> str:
    """Return markdown with its paragraphs broken into lines; headings, lists, tables stay."""
    return "\n\n".join(_filled(block) for block in text.split("\n\n"))


def _filled(block: str) -> str:
    if block.startswith(("#", "- ", "| ")):
        return block
    # Code is not broken: only ASCII spaces are places to break at.
    kept = re.sub("`[^`]*`", lambda code: code[0].replace(" ", "\N{NO-BREAK SPACE}"), block)
    lines = fill(re.sub("[ \n]+", " ", kept), 110, break_long_words=False, break_on_hyphens=False)
    return lines.replace("\N{NO-BREAK SPACE}", " ")


PARTS = {1: ("",), 2: ("counts", "scaled")}
"""What the parts of a key are called, by how many it has."""


@dataclass(frozen=True, slots=True)
class Story:
    """A run, the decision in it that the page follows, and one that stages a short-term memory."""

    trace: Trace
    decision: Decision
    staging: Decision

    @property
    def agent(self) -> int:
        """Whose decision it is."""
        return self.decision.agent

    @property
    def phases(self) -> tuple[str, ...]:
        """Names of the agent's phases."""
        return self.trace.scenario.network.intersections[self.agent].phase_names

    def phase(self, action: int) -> str:
        """Return the name of an action, as code."""
        return f"`{self.phases[action]}`"

    def all_phases(self) -> list[str]:
        """Return the names of all actions, as code."""
        return [self.phase(action) for action in range(len(self.phases))]

    def place(self, agent: int) -> str:
        """Return the name of an agent's intersection, as code."""
        return f"`{self.trace.scenario.network.intersections[agent].id}`"

    def east_becomes(self, variant: int) -> str:
        """Return the side to which a symmetry of the agent's intersection carries the East."""
        shape = self.trace.classes.shape[self.agent]
        first = int(self.trace.classes.movement_image[shape, variant, 0])
        return SIDES[first * len(SIDES) // self.decision.state.size]

    def parts(self, key: IntArray) -> list[tuple[str, IntArray]]:
        """Return the parts of a key, each with its name; each is as long as a state."""
        count = key.size // self.decision.state.size
        return list(zip(PARTS[count], np.split(key, count), strict=True))

    def key(self, key: IntArray) -> str:
        """Return a key in one line."""
        return ", ".join(f"{name} {line(part)}".strip() for name, part in self.parts(key))
