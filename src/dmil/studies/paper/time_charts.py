"""Figures over time: arrivals like the paper's Fig. 4 and memory like its Fig. 5.

Every function takes aggregated tables and returns a chart, or None without the runs for it.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import polars as pl

from dmil.analysis.panel import ordered
from dmil.reports.labels import controller_label, dashes_by_label
from dmil.reports.marks import RULES, Chart, heading, lines
from dmil.reports.theme import REWARD_COLOURS
from dmil.studies.paper.cell_charts import COLOURS
from dmil.studies.paper.cells import REWARD_ORDER
from dmil.studies.paper.published import PAPER_COLUMNS, scenario_label
from dmil.theory import SizeBounds

_DASHES = dashes_by_label() | {
    "Complex + communication": [7, 3],
    "diffusion": [7, 3],
    "most possible, SARSA": [2, 2],
    "most possible, dual memory": [2, 2],
}
_ARRIVED = "vehicles arrived, Vc (veh)"


def arrivals_by_reward(curves: pl.DataFrame, scenario: str) -> Chart | None:
    """Draw arrivals for each reward, architecture fixed (like the paper's Fig. 4, left)."""
    for column in ("Complex", "Simple", "No Memory"):
        chosen = curves.filter(pl.col("column") == column).with_columns(line="reward")
        if chosen.height:
            order = ordered(chosen["line"].unique().to_list(), REWARD_ORDER)
            fixed = "SARSA" if column == "No Memory" else f"dual memory, {column.lower()} classes"
            return lines(
                _with_baselines(curves, chosen),
                [*order, *RULES],
                {**COLOURS, **REWARD_COLOURS},
                _DASHES,
                _ARRIVED,
                heading(f"Arrivals by reward, {scenario_label(scenario)}", fixed),
            )
    return None


def arrivals_by_architecture(curves: pl.DataFrame, scenario: str) -> Chart | None:
    """Draw arrivals for each architecture, reward fixed (like the paper's Fig. 4, right)."""
    chosen, reward = _paper_lines(curves)
    if chosen.is_empty():
        return None
    return lines(
        _with_baselines(curves, chosen),
        [*PAPER_COLUMNS, *RULES],
        COLOURS,
        _DASHES,
        _ARRIVED,
        heading(f"Arrivals by architecture, {scenario_label(scenario)}", f"{reward} reward"),
    )


def memory(curves: pl.DataFrame, scenario: str, what: str, counted: str) -> Chart | None:
    """Draw what agents store, exact SARSA among them (like the paper's Fig. 5)."""
    chosen, reward = memory_lines(curves)
    if chosen.is_empty():
        return None
    return lines(
        chosen,
        ["SARSA exact", *PAPER_COLUMNS],
        COLOURS | {"No Memory": COLOURS["SARSA simple"]},
        _DASHES,
        f"{counted} per agent",
        heading(f"{what}, {scenario_label(scenario)}", f"{reward} reward, mean of agents"),
    )


Bounds = Callable[[int], SizeBounds]
"""What gives the bounds of the theory on the growth of memory in so many decisions."""


def memory_size(curves: pl.DataFrame, scenario: str, bounds: Bounds | None) -> Chart | None:
    """Draw the growth of the paper's size of memory with the bounds of the theory."""
    chosen, reward = memory_lines(curves)
    chosen = chosen.filter(pl.col("line") != "Complex + communication")
    if chosen.is_empty():
        return None
    if bounds is not None:
        chosen = pl.concat([chosen, _bounds(chosen, bounds)])
    sarsa, dual = "most possible, SARSA", "most possible, dual memory"
    return lines(
        chosen,
        ["SARSA exact", sarsa, "Simple", dual, "Complex", "No Memory"],
        COLOURS
        | {"No Memory": COLOURS["SARSA simple"]}
        | {sarsa: COLOURS["SARSA exact"], dual: COLOURS["Simple"]},
        _DASHES,
        "values added per agent",
        heading(
            f"Growth of the memory's size, {scenario_label(scenario)}",
            f"{reward} reward, no communication",
        ),
    )


def _bounds(chosen: pl.DataFrame, bounds: Bounds) -> pl.DataFrame:
    """Worst cases from an empty memory: what a start table holds adds nothing to the growth."""
    times = np.unique(chosen["time_s"].to_numpy())
    found = bounds(len(times))
    worst = {
        "most possible, SARSA": found.sarsa_worst,
        "most possible, dual memory": found.dual_worst,
    }
    parts = [
        pl.DataFrame({"line": name, "time_s": times, "mean": curve.astype(np.float64)})
        for name, curve in worst.items()
    ]
    return pl.concat(parts).with_columns(low="mean", high="mean")


def _paper_lines(curves: pl.DataFrame) -> tuple[pl.DataFrame, str]:
    """Lines of the paper's columns under entropy, or under the first reward there is."""
    chosen = curves.filter(pl.col("column").is_not_null()).with_columns(line="column")
    rewards = chosen["reward"].unique().to_list()
    if not rewards:
        return chosen, ""
    reward = "entropy" if "entropy" in rewards else ordered(rewards, REWARD_ORDER)[0]
    return chosen.filter(pl.col("reward") == reward), reward


def memory_lines(curves: pl.DataFrame) -> tuple[pl.DataFrame, str]:
    """Return the lines of exact SARSA and the paper's columns, and the reward they are for."""
    chosen, reward = _paper_lines(curves)
    table = curves.filter("is_exact_sarsa", pl.col("reward") == reward).with_columns(
        line=pl.lit("SARSA exact")
    )
    # Under most presets "No Memory" is exact SARSA: one line is enough.
    others = chosen.filter(~pl.col("is_exact_sarsa"))
    keep = ("line", "time_s", "mean", "low", "high")
    return pl.concat([table.select(keep), others.select(keep)]), reward


def _with_baselines(curves: pl.DataFrame, chosen: pl.DataFrame) -> pl.DataFrame:
    labels = [controller_label(name) for name in curves["controller"].to_list()]
    baselines = curves.with_columns(line=pl.Series(labels, dtype=pl.String))
    keep = ("line", "time_s", "mean", "low", "high")
    rules = baselines.filter(pl.col("line").is_in(RULES))
    return pl.concat([chosen.select(keep), rules.select(keep)])
