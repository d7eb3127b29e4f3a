"""Verdicts on the bars and claims of the study of memories, computed from the runs at hand."""

from __future__ import annotations

import numpy as np
import polars as pl

from dmil.analysis.verdicts import FEWEST_SEEDS, judge
from dmil.seeding import stream
from dmil.statistics import paired_difference
from dmil.studies.memories.arranged import WAIT, Arranged
from dmil.studies.memories.names import REFERENCES, cell_label, controller_name
from dmil.studies.memories.statements import BARS, Bar

EVIDENCE = pl.Struct(
    {
        "cell": pl.String,
        "controller": pl.String,
        "against": pl.String,
        "value": pl.Float64,
        "low": pl.Float64,
        "high": pl.Float64,
        "n": pl.Int64,
        "outcome": pl.String,
    }
)
CLAIMS_SCHEMA: dict[str, pl.DataType] = {
    "id": pl.String(),
    "section": pl.String(),
    "sentence": pl.String(),
    "rule": pl.String(),
    "holds": pl.Boolean(),
    "verdict": pl.String(),
    "summary": pl.String(),
    "lacking": pl.List(pl.String()),
    "failed": pl.Int64(),
    "evidence": pl.List(EVIDENCE),
}
Item = dict[str, object]


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
    known = {(row["cell"], row["controller"]): row for row in standing.iter_rows(named=True)}
    sizes = {(row["cell"], row["controller"]): row for row in costs.iter_rows(named=True)}
    return pl.DataFrame(
        [_judged(runs, bar, known, sizes) for bar in BARS], schema=CLAIMS_SCHEMA, orient="row"
    )


def _judged(
    runs: Arranged,
    bar: Bar,
    known: dict[tuple[str, str], Item],
    sizes: dict[tuple[str, str], Item],
) -> Item:
    cells, lacking = bar.cells_among(runs.cells)
    names = [name for name in bar.first_among(runs.controllers) if name not in runs.ablations]
    evidence, failed = [], 0
    for cell in cells:
        for name in names:
            place = runs.cells.index(cell), runs.controllers.index(name)
            failed += int(runs.failed[place].sum())
            if bar.measure == "bytes":
                item = _size(sizes.get((cell, name)), cell, name, bar)
            else:
                item = _difference(runs, bar, cell, name, known)
            if item is not None:
                evidence.append(item)
    # Who fails waits without end: that speaks against "below", and not against "above".
    harmless = bar.relation in ("above", "not below")
    holds, verdict = _verdict(evidence, lacking, 0 if harmless else failed)
    return {
        "id": bar.name,
        "section": bar.section,
        "sentence": bar.sentence,
        "rule": _rule(bar),
        "holds": holds,
        "verdict": verdict,
        "summary": _summary(evidence, bar),
        "lacking": lacking if evidence else [],
        "failed": failed,
        "evidence": evidence,
    }


def _rule(bar: Bar) -> str:
    if bar.measure == "bytes":
        return f"bytes per intersection {bar.relation} {bar.threshold:,.0f} in every run"
    threshold = f"{100 * bar.threshold:+.0f} %".replace("-", "−").replace("+0 %", "0")
    if bar.relation == "within":
        threshold = threshold.replace("+", "±")
    return f"95 % interval of the paired difference {bar.relation} {threshold}, in every cell"


def _difference(
    runs: Arranged, bar: Bar, cell: str, name: str, known: dict[tuple[str, str], Item]
) -> Item | None:
    row = known.get((cell, name))
    short = REFERENCES.get(bar.second)
    if row is None or bar.second not in runs.controllers:
        return None
    if short is not None:  # the very number of the table
        keys = (f"{short}_pct", f"{short}_low", f"{short}_high")
        value, low, high = (np.nan if row[key] is None else float(str(row[key])) for key in keys)
        seeds = row["n"]
    else:
        first, second = (
            runs.of(WAIT, cell=cell, controller=each)[:, None] for each in (name, bar.second)
        )
        found = paired_difference(
            first,
            second,
            stream(0, "bootstrap", "memories", cell, bar.second),
            relative=True,
        )
        value, low, high = (100 * float(each[0]) for each in (found.value, found.low, found.high))
        seeds = int(found.seeds[0])
    if np.isnan(value):
        return None
    # Where nothing varies the interval has no width; a rounding error is no difference.
    outcome = judge(bar.relation, bar.threshold, round(low / 100, 12), round(high / 100, 12))
    return _item(cell, name, bar.second, (value, low, high), seeds, outcome)


def _size(row: Item | None, cell: str, name: str, bar: Bar) -> Item | None:
    if row is None or row["bytes_largest"] is None:
        return None
    value = float(str(row["bytes_largest"]))
    outcome = "shown" if value < bar.threshold else "opposite"
    seeds = int(str(row["planned"])) - int(str(row["failed"]))
    return _item(cell, name, "", (value, np.nan, np.nan), seeds, outcome)


def _item(
    cell: str,
    name: str,
    against: str,
    numbers: tuple[float, float, float],
    seeds: object,
    outcome: str,
) -> Item:
    value, low, high = (None if np.isnan(each) else each for each in numbers)
    return {
        "cell": cell,
        "controller": name,
        "against": against,
        "value": value,
        "low": low,
        "high": high,
        "n": seeds,
        "outcome": outcome,
    }


def _verdict(evidence: list[Item], lacking: list[str], failed: int) -> tuple[bool | None, str]:
    if not evidence:
        return None, "not run"
    if min(int(str(one["n"])) for one in evidence) < FEWEST_SEEDS:
        return None, "too few seeds"
    shown = sum(one["outcome"] == "shown" for one in evidence)
    count = f"{shown} of {len(evidence)}"
    if failed:
        return False, f"{failed} run{'s' if failed > 1 else ''} failed; else in {count}"
    if shown < len(evidence):
        return False, f"holds in {count}" if shown else "does not hold"
    if lacking:
        return None, f"holds in all {len(evidence)} run, {len(lacking)} cells were not"
    return True, "holds"


def _summary(evidence: list[Item], bar: Bar) -> str:
    """Give all of a few comparisons, the two extremes of many."""
    if len(evidence) <= 4:
        return "; ".join(_phrase(one, bar) for one in evidence)
    ranked = sorted(evidence, key=lambda one: float(str(one["value"])))
    return f"lowest {_phrase(ranked[0], bar)}; highest {_phrase(ranked[-1], bar)}"


def _phrase(one: Item, bar: Bar) -> str:
    where = cell_label(str(one["cell"]))
    if bar.measure == "bytes":
        return f"{where}: {one['value']:,.0f} B"
    several = "*" in "".join(bar.first)
    who = f", {controller_name(str(one['controller']))}" if several else ""
    number = f"{one['value']:+.1f} %"
    if one["low"] is not None:
        number += f" [{one['low']:+.1f}, {one['high']:+.1f}]"
    return f"{where}{who}: {number.replace('-', '−')}"
