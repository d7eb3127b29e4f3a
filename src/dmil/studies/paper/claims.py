"""Verdicts on the claims, computed from the runs at hand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import polars as pl

from dmil.analysis.claims import Question, difference_text, in_words, undecided
from dmil.results import Results
from dmil.studies.paper.cells import CellEvidence, Cells, cells_of, evaluate
from dmil.studies.paper.published import scenario_label
from dmil.studies.paper.questions import Choose, PaperClaim
from dmil.studies.paper.statements import STATEMENTS

Outcome = Literal["holds", "does not hold", "depends", "not shown", "not judged"]
OUTCOMES: tuple[Outcome, ...] = ("holds", "does not hold", "depends", "not shown", "not judged")
"""How a claim can end: "depends" is one whose questions have different answers."""

ALIKE = 0.9
"""Where two agents had the very same value in this part of the seeds, in the mean of all
comparisons, a question that needs a difference was not put to the test."""
UNTESTED = "not put to the test"

EVIDENCE = pl.Struct(
    {
        **dict.fromkeys(("question", "scenario", "comparison", "measure"), pl.String),
        **dict.fromkeys(("difference_pct", "low_pct", "high_pct"), pl.Float64),
        "n": pl.Int64,
        "outcome": pl.String,
    }
)

CLAIMS_SCHEMA: dict[str, pl.DataType] = {
    **dict.fromkeys(("preset", "id", "source", "place", "sentence", "note", "rule"), pl.String()),
    "holds": pl.Boolean(),
    **dict.fromkeys(("outcome", "verdict", "summary"), pl.String()),
    "evidence": pl.List(EVIDENCE),
}


def claims(results: Results | Cells) -> pl.DataFrame:
    """Judge each claim of the paper, and three of ours, under each preset (ours).

    Each claim is one question or several; each question is a set of comparisons of two cells on the
    same seeds. A comparison is the relative difference of their means with a paired bootstrap 95 %
    interval over seeds, and it

    - shows "below" (or "above") a threshold if the whole interval lies below (above) it,
    - shows "within" if the whole interval lies inside ±5 %,
    - shows "not below" unless the whole interval lies below the threshold,
    - shows the opposite if the interval lies wholly on the other side, else leaves it open.

    A question that all comparisons have to show holds if all do, and does not hold if one shows the
    opposite. One that a single comparison may show ("some …") holds if one does, and does not hold
    only if all show the opposite. What is left is not shown: the runs do not decide it. A question
    on two agents that acted alike in nine of ten runs or more is not put to the test.

    A claim of several questions holds if all of them do; where their answers differ, the verdict
    gives each. The comparisons are those whose runs are there; grids of other sizes than the
    paper's count as long as they have one, or several, intersections like the paper's.

    Returns
    -------
    One row per preset and claim: ``preset``, ``id``, ``source`` (quotation, table, ours), ``place``
    in the paper, ``sentence``, ``note``, ``rule``, ``holds`` (null if not decided, runs are missing
    or there are fewer than five seeds), ``outcome`` (see `OUTCOMES`), ``verdict`` in words,
    ``summary`` of the evidence in words, and ``evidence``, a list of all comparisons.
    """
    cells = results if isinstance(results, Cells) else cells_of(results)
    rows = [
        _judged(cells, preset, statement) for preset in cells.presets for statement in STATEMENTS
    ]
    return pl.DataFrame(rows, schema=CLAIMS_SCHEMA, orient="row")


@dataclass(frozen=True, slots=True)
class _Answer:
    """A question with its evidence and what that decides."""

    question: Question[Choose]
    evidence: list[CellEvidence]
    holds: bool | None
    verdict: str


def _judged(cells: Cells, preset: str, statement: PaperClaim) -> tuple[object, ...]:
    answers = [_answer(cells, preset, question) for question in statement.questions]
    # A question that needs runs which are not there, or does not arise under a preset, is left out.
    asked = [answer for answer in answers if answer.evidence] or answers[:1]
    holds, outcome, verdict = _together(asked)
    return (
        preset,
        statement.name,
        statement.kind,
        statement.place,
        statement.sentence,
        statement.note,
        "; ".join(map(_rule, answers)),
        holds,
        outcome,
        verdict,
        "; ".join(_labelled(answer, in_words(answer.evidence, _phrase)) for answer in asked),
        [_row(answer.question, one) for answer in asked for one in answer.evidence],
    )


def _answer(cells: Cells, preset: str, question: Question[Choose]) -> _Answer:
    comparisons = question.choose(cells, preset)
    evidence = evaluate(cells, comparisons, question.relation, question.threshold)
    judged = verdict_of(evidence, question.quantifier)
    alike = [one.alike for one in evidence]
    if question.needs_difference and alike and np.mean(alike) >= ALIKE:
        judged = None, UNTESTED
    return _Answer(question, evidence, *judged)


def verdict_of(evidence: Sequence[CellEvidence], quantifier: str) -> tuple[bool | None, str]:
    """Say whether a question holds, and how a reader should be told (ours).

    The quantifier says whether "all" or "any" of its comparisons have to show it.
    """
    if reason := undecided(evidence):
        return None, reason
    total = len(evidence)
    shown = sum(one.outcome == "shown" for one in evidence)
    opposite = sum(one.outcome == "opposite" for one in evidence)
    if shown == total or (shown and quantifier == "any"):
        return True, "holds"
    if opposite == total:
        return False, "does not hold"
    if opposite and quantifier == "all":
        share = f"shown in {shown}, refuted in {opposite} of {total}"
        return False, share if shown else "does not hold"
    return None, f"shown in {shown} of {total}" if shown else "not shown"


def _together(answers: Sequence[_Answer]) -> tuple[bool | None, Outcome, str]:
    """Join the answers to the questions of one claim."""
    verdicts = {answer.verdict for answer in answers}
    # What was not put to the test decides nothing, where something else was.
    found = {answer.holds for answer in answers if answer.verdict != UNTESTED} or {None}
    if verdicts <= {"not run", "too few seeds"}:
        return None, "not judged", min(verdicts)
    if len(answers) == 1 or len(verdicts) == 1:
        first = answers[0]
        outcome: Outcome = (
            "not shown" if first.holds is None else "holds" if first.holds else "does not hold"
        )
        return first.holds, outcome, first.verdict
    verdict = "; ".join(map(_short, answers))
    if found == {True}:
        return True, "holds", verdict if UNTESTED in verdicts else "holds"
    if found == {False}:
        return False, "does not hold", verdict
    if True in found:
        return None, "depends", verdict
    # What is left was not shown, or refuted as far as it was put to the test.
    return (False, "does not hold", verdict) if False in found else (None, "not shown", verdict)


def _short(answer: _Answer) -> str:
    """Say yes or no to a question by its label, and in how many comparisons where it differs."""
    word = answer.verdict if answer.holds is None else "yes" if answer.holds else "no"
    counted = f" ({answer.verdict})" if answer.verdict.startswith("shown") and word == "no" else ""
    return f"{word} {answer.question.label}{counted}"


def _rule(answer: _Answer) -> str:
    """Say what a question asks, of all comparisons or of one, and on which networks."""
    question = answer.question
    rule = f"{question.label}: {question.text}" if question.label else question.text
    if question.quantifier == "all":
        rule += ", in every comparison"
    scenarios = dict.fromkeys(one.comparison.scenario for one in answer.evidence)
    where = ", ".join(map(scenario_label, scenarios))
    return f"{rule} ({where})" if where else rule


def _labelled(answer: _Answer, text: str) -> str:
    return f"{answer.question.label}: {text}" if answer.question.label and text else text


def _phrase(one: CellEvidence) -> str:
    number = difference_text(*(100 * each for each in (one.value, one.low, one.high)))
    return f"{scenario_label(one.comparison.scenario)}, {one.comparison.label}: {number}"


def _row(question: Question[Choose], one: CellEvidence) -> dict[str, object]:
    return {
        "question": question.label,
        "scenario": one.comparison.scenario,
        "comparison": one.comparison.label,
        "measure": one.comparison.measure,
        "difference_pct": _percent(one.value),
        "low_pct": _percent(one.low),
        "high_pct": _percent(one.high),
        "n": one.seeds,
        "outcome": one.outcome,
    }


def _percent(value: float) -> float | None:
    return 100 * value if np.isfinite(value) else None
