"""Where we read, fill in or correct the paper: one table for settings, report and docs/paper.md.

Marks: P, stated by the paper; A, assumed: open in the paper, and of the readings tried the one that
gives its magnitudes; F, fitted to its table, stated nowhere; corrected; ours.
"""

from __future__ import annotations

from dmil.interpretations.minds import AGENTS, CENTRAL, CLASSES, TRAINING
from dmil.interpretations.model import MEANING, Interpretation
from dmil.interpretations.world import MEASURES, QUEUES, REWARDS, ROADS

__all__ = [
    "INTERPRETATIONS",
    "MEANING",
    "TOPICS",
    "Interpretation",
    "interpretations_markdown",
    "mark",
]

INTERPRETATIONS: tuple[Interpretation, ...] = (
    *ROADS,
    *QUEUES,
    *MEASURES,
    *REWARDS,
    *CLASSES,
    *AGENTS,
    *CENTRAL,
    *TRAINING,
)
"""Every choice, in the order of the system."""


TOPICS: tuple[str, ...] = tuple(dict.fromkeys(each.topic for each in INTERPRETATIONS))

_MARKS = {each.setting: each.mark for each in INTERPRETATIONS if each.setting}


def mark(setting: str) -> str:
    """Return the mark of a setting as its description ends in it: "[A]" (ours).

    Raises
    ------
    KeyError
        If the table has no such setting.
    """
    return f"[{_MARKS[setting]}]"


def interpretations_markdown(topic: str) -> str:
    """Return the table of a topic as docs/paper.md has it (ours)."""
    lines = ["| what | paper | here | mark | change it by |", "|-|-|-|-|-|"]
    for each in INTERPRETATIONS:
        if each.topic == topic:
            change = f"`{each.change}`" if each.change else ""
            row = (each.what, each.paper, each.here, each.mark, change)
            lines.append("| " + " | ".join(cell.replace("|", r"\|") for cell in row) + " |")
    return "\n".join(lines) + "\n"
