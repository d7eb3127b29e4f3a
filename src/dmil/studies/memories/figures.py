"""All figures of the study of memories, named, titled and explained."""

from __future__ import annotations

from collections.abc import Iterator

import polars as pl

from dmil.reports.export import Drawn, Figure, darkened, drawn_figures
from dmil.studies.memories import charts, curve_charts
from dmil.studies.memories.names import LONGEST_QUEUE_APPROACHING, MAX_PRESSURE, ranked
from dmil.studies.memories.statements import SUBJECT
from dmil.studies.memories.tables import MemoriesTables

HEADLINE = "Waiting against max-pressure"
MOST_LINES = 9
DARK = "dark"
"""Section of pictures for dark pages, which no page of ours shows."""


def figures_of_study(tables: MemoriesTables) -> Iterator[Figure]:
    """Yield the figures that the runs allow; the headline also for dark pages (ours)."""
    runs = tables.runs
    kept = [name for name in runs.controllers if name not in runs.ablations]
    standing, overall, cost, learning, memory = (
        getattr(tables, name).filter(pl.col("controller").is_in(kept))
        for name in ("standing", "overall", "cost", "learning", "memory")
    )
    drawn: list[Drawn] = [
        (
            "differences",
            "headline",
            "Paired difference in mean waiting time from max-pressure, in every case; left of the "
            "line is better.",
            charts.differences(standing, runs.cells, HEADLINE),
        ),
        (
            "standing",
            "standing",
            "All controllers, over all cases and seeds. On the line: equal to max-pressure.",
            charts.standing_chart(overall),
        ),
        (
            "profile",
            "standing",
            "Performance profiles: at 1, the share of runs in which vehicles wait no longer than "
            "under max-pressure. Failed runs never reach any value.",
            charts.profile_chart(tables.profiles, _in_profile(overall)),
        ),
        (
            "waiting-and-bytes",
            "memory",
            "Further left: less memory; lower: shorter waits. Dashed: rules without memory.",
            charts.waiting_and_bytes(overall, cost),
        ),
        (
            "memory-over-time",
            "memory",
            "Memory growth over training.",
            curve_charts.memory_chart(memory, runs.cells),
        ),
        (
            "learning",
            "learning",
            "Below the line: better than max-pressure.",
            curve_charts.learning_chart(learning, runs.cells),
        ),
        (
            "ablation",
            "ablation",
            "Each variant against factored memory with its default settings.",
            curve_charts.ablation_chart(tables.ablation, SUBJECT),
        ),
    ]
    for made in drawn_figures(drawn):
        yield made
        if made.section == "headline":
            yield darkened(made, DARK)


def _in_profile(overall: pl.DataFrame) -> list[str]:
    """Return the best controllers; max-pressure itself is the line at 1."""
    known = ranked(overall).filter(
        pl.col("controller") != MAX_PRESSURE, pl.col("cells") == overall["cells"].max()
    )
    names: list[str] = known["controller"].to_list()
    front = [name for name in (SUBJECT, LONGEST_QUEUE_APPROACHING) if name in names]
    return list(dict.fromkeys([*front, *names]))[:MOST_LINES]
