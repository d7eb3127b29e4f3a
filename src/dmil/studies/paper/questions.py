"""How the claims of the paper are written down."""

from __future__ import annotations

from collections.abc import Callable

from dmil.analysis.claims import Claim, Question, Relation
from dmil.studies.paper.selections import PHYSICAL, Choose

#: Two things count as the same if the interval of their relative difference lies within ±5 %, and
#: an expense is little, or tiny, if the whole interval lies below +5 %.
SAME_WITHIN = 0.05

#: Less than this is no reduction of memory: an interval around 0 then refutes one.
NOTICEABLE = 0.01

PaperClaim = Claim[Choose]
"""Its kind is quotation (the paper's own words), table (numbers of its tables) or ours."""


def claim(
    name: str,
    sentence: str,
    *questions: Question[Choose],
    place: str = "§VI-D",
    kind: str = "quotation",
    note: str = "",
) -> PaperClaim:
    """Return a claim of the paper, by default a quotation of the section with its results."""
    return Claim(name, kind, sentence, questions, place, note)


def by_reward(
    text: str,
    choose: Callable[[tuple[str, ...]], Choose],
    relation: Relation,
    threshold: float = 0.0,
) -> list[Question[Choose]]:
    """Ask for each of the rewards that a sentence does not tell apart, and that differ."""
    return [
        Question(f"{text} {label}", choose(rewards), relation, threshold, label=label)
        for label, rewards in (
            ("under entropy and diffusion", PHYSICAL),
            ("under default", ("default",)),
        )
    ]


def percent(part: float) -> str:
    """Return "5 %" for 0.05 (ours)."""
    return f"{100 * part:.0f} %"
