"""Verdicts on the claims, computed from the runs at hand."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import polars as pl

from dmil.analysis.cells import Cells, cells_of
from dmil.analysis.comparisons import Evidence, evaluate
from dmil.analysis.paper import scenario_label
from dmil.analysis.statements import STATEMENTS, Statement
from dmil.results import Results

#: With fewer seeds a 95 % interval covers the truth in far fewer than 92 % of studies (three seeds:
#: 75 %, two: 50 %), so no verdict is given.
FEWEST_SEEDS = 5

EVIDENCE = pl.Struct(
    {
        "scenario": pl.String,
        "comparison": pl.String,
        "measure": pl.String,
        "difference_pct": pl.Float64,
        "low_pct": pl.Float64,
        "high_pct": pl.Float64,
        "n": pl.Int64,
        "outcome": pl.String,
    }
)

CLAIMS_SCHEMA: dict[str, pl.DataType] = {
    "preset": pl.String(),
    "id": pl.String(),
    "source": pl.String(),
    "sentence": pl.String(),
    "rule": pl.String(),
    "holds": pl.Boolean(),
    "verdict": pl.String(),
    "summary": pl.String(),
    "evidence": pl.List(EVIDENCE),
}


def claims(results: Results | Cells) -> pl.DataFrame:
    """Judge each claim of the paper, and two facts of ours, under each preset (ours).

    Each claim is a set of comparisons of two cells on the same seeds. A comparison is the relative
    difference of their means with a paired bootstrap 95 % interval over seeds, and it

    - shows "below" (or "above") a threshold if the whole interval lies below (above) it,
    - shows "within" if the whole interval lies inside ±5 %,
    - shows "not below" unless the whole interval lies below the threshold,
    - shows the opposite if the interval lies wholly on the other side, else leaves it open.

    A claim holds if all its comparisons show it (for "up to" and "more than": if one does). The
    comparisons are those whose runs are there; grids of other sizes than the paper's count as
    long as they have one, or several, intersections like the paper's.

    Returns
    -------
    One row per preset and claim: ``preset``, ``id``, ``source`` (paper, ours), ``sentence``,
    ``rule``, ``holds`` (null if runs are missing or there are fewer than five seeds), ``verdict``
    in words, ``summary`` of the evidence in words, and ``evidence``, a list of all comparisons.
    """
    cells = results if isinstance(results, Cells) else cells_of(results)
    rows = [
        _judged(cells, preset, statement) for preset in cells.presets for statement in STATEMENTS
    ]
    return pl.DataFrame(rows, schema=CLAIMS_SCHEMA, orient="row")


def _judged(cells: Cells, preset: str, statement: Statement) -> tuple[object, ...]:
    comparisons = statement.choose(cells, preset)
    evidence = evaluate(cells, comparisons, statement.relation, statement.threshold)
    holds, verdict = _verdict(evidence, statement.quantifier)
    rule = statement.question
    if statement.quantifier == "all":
        rule += "; every comparison has to show it"
    return (
        preset,
        statement.name,
        statement.source,
        statement.sentence,
        rule,
        holds,
        verdict,
        _in_words(evidence),
        [_row(one) for one in evidence],
    )


def _verdict(evidence: Sequence[Evidence], quantifier: str) -> tuple[bool | None, str]:
    if not evidence:
        return None, "not run"
    if min(one.seeds for one in evidence) < FEWEST_SEEDS:
        return None, "too few seeds"
    shown = sum(one.outcome == "shown" for one in evidence)
    opposite = sum(one.outcome == "opposite" for one in evidence)
    if shown == len(evidence) or (shown and quantifier == "any"):
        return True, "holds"
    if opposite == len(evidence):
        return False, "does not hold"
    if shown:
        return False, f"holds in {shown} of {len(evidence)}"
    return False, "not shown" if not opposite else "does not hold"


def _in_words(evidence: Sequence[Evidence]) -> str:
    """Give all of a few comparisons, the two extremes of many."""
    if len(evidence) <= 4:
        return "; ".join(_phrase(one) for one in evidence)
    ranked = sorted(evidence, key=lambda one: one.value)
    return f"lowest {_phrase(ranked[0])}; highest {_phrase(ranked[-1])}"


def _phrase(one: Evidence) -> str:
    number = f"{100 * one.value:+.1f} %"
    if not np.isnan(one.low):
        number += f" [{100 * one.low:+.1f}, {100 * one.high:+.1f}]"
    where = scenario_label(one.comparison.scenario)
    return f"{where}, {one.comparison.label}: {number.replace('-', '−')}"


def _row(one: Evidence) -> dict[str, object]:
    return {
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
