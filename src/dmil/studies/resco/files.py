"""Tables of the study on the RESCO benchmark for other papers: LaTeX, with booktabs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import polars as pl

from dmil.reports.labels import contender_label, network_label, simulator_label
from dmil.studies.resco.published import METHODS, SOURCE, published_by


def delay_latex(headline: pl.DataFrame, judge: str) -> str:
    r"""Return controllers by networks as a LaTeX tabular: mean and interval of the delay.

    An asterisk marks those that are not shown to be worse than the best.
    """
    networks = headline["scenario"].unique(maintain_order=True).to_list()
    entries = {(row["contender"], row["scenario"]): row for row in headline.iter_rows(named=True)}
    lines = [
        f"% average delay in s in {simulator_label(judge)}: mean [95 % interval over seeds];",
        "% * not shown to be worse than the best (paired interval);",
        f"% published: best training episode (mean of the last 10), {SOURCE}",
        r"\begin{tabular}{l" + "r" * len(networks) + "}",
        r"\toprule",
        _line("", *(network_label(name) for name in networks)),
        r"\midrule",
    ]
    for name in headline["contender"].unique(maintain_order=True):
        cells = [_entry(entries.get((name, network))) for network in networks]
        lines.append(_line(contender_label(name), *cells))
    known = {name: published_by(name) for name in networks}
    methods = [name for name in METHODS if any(name in values for values in known.values())]
    if methods:
        lines.append(r"\midrule")
    for method in methods:
        cells = []
        for network in networks:
            value = known[network].get(method)
            last = "" if value is None or value.last_s is None else f" ({value.last_s:.1f})"
            cells.append("--" if value is None else f"{value.best_s:.1f}{last}")
        lines.append(_line(f"published {method}", *cells))
    return "\n".join([*lines, r"\bottomrule", r"\end{tabular}", ""])


def agreement_latex(agreement: pl.DataFrame) -> str:
    r"""Return Kendall's \tau of the delays by network as a LaTeX tabular."""
    chosen = agreement.filter(pl.col("metric") == "delay_s")
    simulators = chosen["simulator"].unique(maintain_order=True).to_list()
    entries = {(row["scenario"], row["simulator"]): row for row in chosen.iter_rows(named=True)}
    heads = (r"$\tau$", "difference")
    lines = [
        "% Kendall's tau of the ranks by delay, SUMO against the queue simulator;",
        "% median of delay / SUMO's delay - 1 in %; [95 % interval over seeds]",
        r"\begin{tabular}{l" + "rr" * len(simulators) + "}",
        r"\toprule",
        _line("", *(f"{simulator_label(name)}: {what}" for name in simulators for what in heads)),
        r"\midrule",
    ]
    for scenario in chosen["scenario"].unique(maintain_order=True):
        cells = []
        for simulator in simulators:
            row = entries.get((scenario, simulator))
            cells += ["--", "--"] if row is None else _agreement_entry(row)
        lines.append(_line("all" if scenario is None else network_label(scenario), *cells))
    return "\n".join([*lines, r"\bottomrule", r"\end{tabular}", ""])


def _line(*cells: str) -> str:
    return " & ".join(cell.replace("_", r"\_") for cell in cells) + r" \\"


def _entry(row: Mapping[str, Any] | None) -> str:
    if row is None:
        return "--"
    mark = r"$^{*}$" if row["among_best"] else ""
    return f"{row['mean']:.1f}{mark}{_ends(row['low'], row['high'], 1)}"


def _agreement_entry(row: Mapping[str, Any]) -> list[str]:
    tau = "--" if row["tau"] is None else f"{row['tau']:.2f}"
    difference = f"{100 * row['difference']:+.0f}\\,\\%".replace("-", "$-$")
    return [f"{tau}{_ends(row['tau_low'], row['tau_high'], 2)}", difference]


def _ends(low: float | None, high: float | None, digits: int) -> str:
    if low is None or high is None:
        return ""
    return rf" {{\scriptsize [{low:.{digits}f}, {high:.{digits}f}]}}".replace("[-", "[$-$")
