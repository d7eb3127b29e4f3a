"""What a claim is, and what the intervals of comparisons show of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, Literal, TypeVar

import numpy as np

#: With fewer seeds a 95 % interval covers the truth in far fewer than 92 % of studies (three seeds:
#: 75 %, two: 50 %), so no verdict is given.
FEWEST_SEEDS = 5

Relation = Literal["below", "above", "within", "not below", "not above"]
Outcome = Literal["shown", "opposite", "open"]
Chosen = TypeVar("Chosen")
Compared = TypeVar("Compared")


@dataclass(frozen=True, slots=True)
class Question(Generic[Chosen]):
    """One way to ask whether a claim holds.

    Attributes
    ----------
    text: str
        What is compared, in one line.
    choose
        What tells which comparisons it is about.
    relation, threshold
        What each comparison has to show.
    quantifier: str
        Whether all comparisons have to show it or one is enough.
    label: str
        What tells this question from the others of its claim: how it is read or counted.
    needs_difference: bool
        Whether it is put to the test only where the two compared acted differently.
    """

    text: str
    choose: Chosen
    relation: Relation
    threshold: float = 0.0
    quantifier: Literal["all", "any"] = "all"
    label: str = ""
    needs_difference: bool = False


@dataclass(frozen=True, slots=True)
class Claim(Generic[Chosen]):
    """One claim and the questions that decide it.

    Attributes
    ----------
    name, kind: str
        Short identifier; what sort of claim it is.
    sentence: str
        The claim. Of a quotation every word is the paper's, an ellipsis marks what is left out.
    questions
        One, or several where the sentence can be read, or the thing counted, in several ways.
    place: str
        Where it stands in a paper.
    note: str
        What a reader should know beside the verdict, such as what the paper's own table says.
    """

    name: str
    kind: str
    sentence: str
    questions: tuple[Question[Chosen], ...]
    place: str = ""
    note: str = ""


@dataclass(frozen=True, slots=True)
class Evidence(Generic[Compared]):
    """A comparison with its result.

    ``alike`` is the part of the seeds in which both have the very same value: where it is near 1
    the two acted alike, and nothing was put to the test.
    """

    comparison: Compared
    value: float
    low: float
    high: float
    seeds: int
    outcome: Outcome
    alike: float = 0.0


def judge(relation: Relation, threshold: float, low: float, high: float) -> Outcome:
    """Say whether an interval shows a relation to a threshold, its opposite, or leaves it open.

    "below": the whole interval lies below the threshold; "above": above it; "within": inside
    ±threshold; "not below": its upper end is not below the threshold; "not above": its lower end is
    not above it. Without an interval (one seed) the question is open.
    """
    if np.isnan(low) or np.isnan(high):
        return "open"
    below, above = high < threshold, low > threshold
    inside = -threshold <= low and high <= threshold
    shown, opposite = {
        "below": (below, above),
        "above": (above, below),
        "within": (inside, above or high < -threshold),
        "not below": (not below, below),
        "not above": (not above, above),
    }[relation]
    return "shown" if shown else "opposite" if opposite else "open"


def undecided(evidence: Sequence[Evidence[Compared]]) -> str | None:
    """Say why comparisons give no verdict, if they give none."""
    if not evidence:
        return "not run"
    return "too few seeds" if min(one.seeds for one in evidence) < FEWEST_SEEDS else None


def in_words(
    evidence: Sequence[Evidence[Compared]], phrase: Callable[[Evidence[Compared]], str]
) -> str:
    """Give all of a few comparisons, the two extremes of many."""
    if len(evidence) <= 4:
        return "; ".join(map(phrase, evidence))
    ranked = sorted(evidence, key=lambda one: one.value)
    return f"lowest {phrase(ranked[0])}; highest {phrase(ranked[-1])}"


def difference_text(percent: float, low: float | None, high: float | None) -> str:
    """Return "−3.1 % [−4.0, −2.2]"; the interval is left out where there is none."""
    text = f"{percent:+.1f} %"
    if low is not None and high is not None and not np.isnan(low):
        text += f" [{low:+.1f}, {high:+.1f}]"
    return text.replace("-", "−")
