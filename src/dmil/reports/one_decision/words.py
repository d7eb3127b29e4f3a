"""How the page shows numbers, queues and tables."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from textwrap import fill

import numpy as np
import numpy.typing as npt

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
