"""What a claim is: a sentence and the questions that decide it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from dmil.analysis.verdicts import Relation
from dmil.studies.paper.selections import PHYSICAL, Choose

#: Two things count as the same if the interval of their relative difference lies within ±5 %, and
#: an expense is little, or tiny, if the whole interval lies below +5 %.
SAME_WITHIN = 0.05

#: Less than this is no reduction of memory: an interval around 0 then refutes one.
NOTICEABLE = 0.01

Source = Literal["quotation", "table", "ours"]


@dataclass(frozen=True, slots=True)
class Question:
    """One way to ask whether a claim holds.

    Parameters
    ----------
    text
        What is compared, in one line.
    choose
        Yields the comparisons for one preset.
    relation, threshold
        What each comparison has to show.
    quantifier
        Whether all comparisons have to show it or one is enough.
    label
        What tells this question from the others of its claim: how it is read or counted.
    needs_difference
        Whether it is put to the test only where the two compared acted differently.
    """

    text: str
    choose: Choose
    relation: Relation
    threshold: float = 0.0
    quantifier: Literal["all", "any"] = "all"
    label: str = ""
    needs_difference: bool = False


@dataclass(frozen=True, slots=True)
class Claim:
    """One claim and the questions that decide it.

    Parameters
    ----------
    name
        Short identifier.
    source
        Whether the sentence is the paper's own words, tells numbers of its tables, or is ours.
    place
        Where it stands in the paper; empty for ours.
    sentence
        The claim. Of a quotation every word is the paper's, an ellipsis marks what is left out.
    questions
        One, or several where the sentence can be read, or the thing counted, in several ways.
    note
        What a reader should know beside the verdict, such as what the paper's own table says.
    """

    name: str
    source: Source
    place: str
    sentence: str
    questions: tuple[Question, ...]
    note: str = ""


BY_REWARD: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("under entropy and diffusion", PHYSICAL),
    ("under default", ("default",)),
)
"""Rewards that a sentence does not tell apart, and that give different answers."""


def percent(part: float) -> str:
    """Return "5 %" for 0.05 (ours)."""
    return f"{100 * part:.0f} %"
