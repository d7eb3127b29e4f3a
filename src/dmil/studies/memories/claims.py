"""Verdicts on the bars and claims of the study of memories, computed from the runs at hand."""

from __future__ import annotations

from functools import partial
from itertools import product
from typing import Any

import numpy as np
import polars as pl

from dmil.analysis.claims import (
    Claim,
    Evidence,
    Outcome,
    Question,
    difference_text,
    in_words,
    judge,
    undecided,
)
from dmil.analysis.panel import rows_by
from dmil.reports.contenders import controller_name
from dmil.seeding import stream
from dmil.statistics import paired_difference
from dmil.studies.memories.arranged import WAIT, Arranged
from dmil.studies.memories.names import REFERENCES, cell_label
from dmil.studies.memories.statements import BARS, Pairs

EVIDENCE = pl.Struct(
    {
        **dict.fromkeys(("cell", "controller", "against"), pl.String),
        **dict.fromkeys(("value", "low", "high"), pl.Float64),
        "n": pl.Int64,
        "outcome": pl.String,
    }
)
CLAIMS_SCHEMA: dict[str, pl.DataType] = {
    **dict.fromkeys(("id", "section", "sentence", "rule"), pl.String()),
    "holds": pl.Boolean(),
    **dict.fromkeys(("verdict", "summary"), pl.String()),
    "lacking": pl.List(pl.String()),
    "failed": pl.Int64(),
    "evidence": pl.List(EVIDENCE),
}
Item = dict[str, Any]
PairEvidence = Evidence[tuple[str, str, str]]
"""Of cell, controller, and whom it is compared with."""


def claims(runs: Arranged, standing: pl.DataFrame, costs: pl.DataFrame) -> pl.DataFrame:
    """Judge every bar and claim (ours).

    A comparison is the relative difference of mean waiting on the same vehicles with its paired
    95 % interval over seeds. It shows "below" if the whole interval lies below the threshold, "not
    above" unless the whole interval lies above it, and so on. A claim holds if all comparisons show
    it, in all cells it is about; a run that failed counts as one that waits without end.

    Parameters
    ----------
    runs, standing, costs
        The study.

    Returns
    -------
    One row per claim: ``id``, ``section``, ``sentence``, ``rule``; ``holds`` (null if runs are
    missing or there are fewer than five seeds), ``verdict`` and ``summary`` in words, ``lacking``
    (patterns of cells that were not run), ``failed`` runs, ``evidence``: all comparisons,
    differences in %, sizes in bytes.
    """
    known, sizes = (rows_by(table, "cell", "controller") for table in (standing, costs))
    return pl.DataFrame(
        [_judged(runs, claim, known, sizes) for claim in BARS], schema=CLAIMS_SCHEMA, orient="row"
    )


def _judged(
    runs: Arranged,
    claim: Claim[Pairs],
    known: dict[tuple[str, ...], Item],
    sizes: dict[tuple[str, ...], Item],
) -> Item:
    (question,) = claim.questions
    pairs = question.choose
    cells, lacking = pairs.cells_among(runs.cells)
    names = [name for name in pairs.first_among(runs.controllers) if name not in runs.ablations]
    evidence, failed = [], 0
    for cell, name in product(cells, names):
        place = runs.cells.index(cell), runs.controllers.index(name)
        failed += int(runs.failed[place].sum())
        if pairs.measure == "bytes":
            found = _size(sizes.get((cell, name)), question.threshold)
        else:
            found = _difference(runs, question, cell, name, known)
        if found is not None:
            evidence.append(Evidence((cell, name, pairs.second), *found))
    # Who fails waits without end: that speaks against "below", and not against "above".
    harmless = question.relation in ("above", "not below")
    holds, verdict = _verdict(evidence, lacking, 0 if harmless else failed)
    return {
        "id": claim.name,
        "section": claim.kind,
        "sentence": claim.sentence,
        "rule": question.text,
        "holds": holds,
        "verdict": verdict,
        "summary": in_words(evidence, partial(_phrase, pairs)),
        "lacking": lacking if evidence else [],
        "failed": failed,
        "evidence": [_row(one) for one in evidence],
    }


def _difference(
    runs: Arranged,
    question: Question[Pairs],
    cell: str,
    name: str,
    known: dict[tuple[str, ...], Item],
) -> tuple[float, float, float, int, Outcome] | None:
    other = question.choose.second
    row, short = known.get((cell, name)), REFERENCES.get(other)
    if row is None or other not in runs.controllers:
        return None
    if short is not None:  # the very number of the table
        keys = (f"{short}_pct", f"{short}_low", f"{short}_high")
        value, low, high = (np.nan if row[key] is None else row[key] for key in keys)
        seeds = row["n"]
    else:
        first, second = (
            runs.of(WAIT, cell=cell, controller=each)[:, None] for each in (name, other)
        )
        rng = stream(0, "bootstrap", "memories", cell, other)
        found = paired_difference(first, second, rng, relative=True)
        value, low, high = (100 * float(each[0]) for each in (found.value, found.low, found.high))
        seeds = int(found.seeds[0])
    if np.isnan(value):
        return None
    # Where nothing varies the interval has no width; a rounding error is no difference.
    ends = round(low / 100, 12), round(high / 100, 12)
    return value, low, high, seeds, judge(question.relation, question.threshold, *ends)


def _size(row: Item | None, threshold: float) -> tuple[float, float, float, int, Outcome] | None:
    if row is None or row["bytes_largest"] is None:
        return None
    outcome: Outcome = "shown" if row["bytes_largest"] < threshold else "opposite"
    return row["bytes_largest"], np.nan, np.nan, row["planned"] - row["failed"], outcome


def _row(one: PairEvidence) -> Item:
    value, low, high = (None if np.isnan(each) else each for each in (one.value, one.low, one.high))
    names = dict(zip(("cell", "controller", "against"), one.comparison, strict=True))
    numbers = {"value": value, "low": low, "high": high, "n": one.seeds}
    return names | numbers | {"outcome": one.outcome}


def _verdict(
    evidence: list[PairEvidence], lacking: list[str], failed: int
) -> tuple[bool | None, str]:
    if reason := undecided(evidence):
        return None, reason
    shown = sum(one.outcome == "shown" for one in evidence)
    count = f"{shown} of {len(evidence)}"
    if failed:
        return False, f"{failed} run{'s' if failed > 1 else ''} failed; else in {count}"
    if shown < len(evidence):
        return False, f"holds in {count}" if shown else "does not hold"
    if lacking:
        return None, f"holds in all {len(evidence)} run, {len(lacking)} cells were not"
    return True, "holds"


def _phrase(pairs: Pairs, one: PairEvidence) -> str:
    cell, controller, _ = one.comparison
    if pairs.measure == "bytes":
        return f"{cell_label(cell)}: {one.value:,.0f} B"
    who = f", {controller_name(controller)}" if "*" in "".join(pairs.first) else ""
    return f"{cell_label(cell)}{who}: {difference_text(one.value, one.low, one.high)}"
