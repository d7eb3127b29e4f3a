"""Tables of the study on the RESCO benchmark for other papers: LaTeX, with booktabs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import polars as pl

from dmil.analysis.panel import rows_by
from dmil.reports.files import latex
from dmil.reports.labels import contender_label, network_label, simulator_label
from dmil.studies.resco.published import METHODS, SOURCE, Published, published_by


def delay_latex(headline: pl.DataFrame, judge: str) -> str:
    r"""Return controllers by networks as a LaTeX tabular: mean and interval of the delay.

    An asterisk marks those that are not shown to be worse than the best.
    """
    networks = headline["scenario"].unique(maintain_order=True).to_list()
    entries = rows_by(headline, "contender", "scenario")
    ours = [
        [contender_label(name), *(_entry(entries.get((name, network))) for network in networks)]
        for name in headline["contender"].unique(maintain_order=True)
    ]
    known = {name: published_by(name) for name in networks}
    theirs = [
        [f"published {name}", *(_published(values.get(name)) for values in known.values())]
        for name in METHODS
        if any(name in values for values in known.values())
    ]
    notes = (
        f"average delay in s in {simulator_label(judge)}: mean [95 % interval over seeds];",
        "* not shown to be worse than the best (paired interval);",
        f"published: best training episode (mean of the last 10), {SOURCE}",
    )
    return _latex(notes, ["", *map(network_label, networks)], ours, theirs)


def agreement_latex(agreement: pl.DataFrame) -> str:
    r"""Return Kendall's \tau of the delays by network as a LaTeX tabular."""
    chosen = agreement.filter(pl.col("metric") == "delay_s")
    simulators = chosen["simulator"].unique(maintain_order=True).to_list()
    entries = rows_by(chosen, "scenario", "simulator")
    rows = [
        [
            "all" if scenario is None else network_label(scenario),
            *(text for each in simulators for text in _agreement(entries.get((scenario, each)))),
        ]
        for scenario in chosen["scenario"].unique(maintain_order=True)
    ]
    notes = (
        "Kendall's tau of the ranks by delay, SUMO against the queue simulator;",
        "median of delay / SUMO's delay - 1 in %; [95 % interval over seeds]",
    )
    heads = [
        f"{simulator_label(name)}: {what}"
        for name in simulators
        for what in (r"$\tau$", "difference")
    ]
    return _latex(notes, ["", *heads], rows)


def _latex(notes: Sequence[str], *lines: Any) -> str:
    head, *parts = lines
    safe = [[[cell.replace("_", r"\_") for cell in row] for row in part] for part in parts]
    return latex(notes, [cell.replace("_", r"\_") for cell in head], *safe)


def _published(value: Published | None) -> str:
    if value is None:
        return "--"
    return f"{value.best_s:.1f}" + ("" if value.last_s is None else f" ({value.last_s:.1f})")


def _entry(row: Mapping[str, Any] | None) -> str:
    if row is None:
        return "--"
    mark = r"$^{*}$" if row["among_best"] else ""
    return f"{row['mean']:.1f}{mark}{_ends(row['low'], row['high'], 1)}"


def _agreement(row: Mapping[str, Any] | None) -> list[str]:
    if row is None:
        return ["--", "--"]
    tau = "--" if row["tau"] is None else f"{row['tau']:.2f}"
    difference = f"{100 * row['difference']:+.0f}\\,\\%".replace("-", "$-$")
    return [f"{tau}{_ends(row['tau_low'], row['tau_high'], 2)}", difference]


def _ends(low: float | None, high: float | None, digits: int) -> str:
    if low is None or high is None:
        return ""
    return rf" {{\scriptsize [{low:.{digits}f}, {high:.{digits}f}]}}".replace("[-", "[$-$")
