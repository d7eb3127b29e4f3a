"""All figures of one study, named, titled and explained."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

from dmil.analysis.panel import ordered
from dmil.controllers.tabular.settings import DualMemorySettings
from dmil.reports.export import Drawn, Figure, drawn_figures, slug
from dmil.reports.html import find_value
from dmil.results import Results
from dmil.studies.paper import cell_charts, time_charts
from dmil.studies.paper.cells import CELL, ENTRIES, Cells
from dmil.studies.paper.published import PAPER_COLUMNS, intersections_of
from dmil.studies.paper.summaries import curves
from dmil.studies.paper.tables import PaperTables
from dmil.studies.paper.time_charts import Bounds
from dmil.theory import size_bounds


def gallery(results: Results, tables: PaperTables, preset: str) -> Iterator[Figure]:
    """Yield the figures that the runs of a study allow, those of one preset for it (ours)."""
    yield from drawn_figures(_of_study(tables, preset))
    for scenario in reversed(tables.cells.scenarios):
        yield from drawn_figures(_of_scenario(results, tables, preset, scenario), scenario)


def _of_study(tables: PaperTables, preset: str) -> list[Drawn]:
    return [
        (
            "paper_against_ours",
            "paper",
            "Waiting time per vehicle divided by the vehicles arrived at the horizon. Diamonds: "
            "the paper's Table II. Dots: this run, with 95 % intervals. Grey lines: baselines of "
            "this run, which the paper does not have.",
            cell_charts.paper_against_ours(tables.paper, preset),
        ),
        (
            "against_max_pressure",
            "headline",
            "Extra waiting time against max-pressure, with the same demand. Left of the "
            "line: better than max-pressure.",
            cell_charts.against_max_pressure(tables.summary, preset),
        ),
        (
            "sensitivity",
            "sensitivity",
            "The same agents under the presets of this study; the assumptions list what "
            "each adds to the paper.",
            cell_charts.preset_sensitivity(tables.sensitivity),
        ),
    ]


def _of_scenario(
    results: Results, tables: PaperTables, preset: str, scenario: str
) -> Iterator[Drawn]:
    end = slug(scenario)
    arrived = curves(results, "arrived_veh", preset, scenario)
    recorded = curves(results, "long_entries", preset, scenario)
    grown = curves(results, "long_entries", preset, scenario, since_start=True)
    entries = curves(results, "entries", preset, scenario, since_start=True)
    sizes = curves(results, "msize_per_agent", preset, scenario, since_start=True)
    bounds = _memory_bounds(results, scenario)
    bounded = " Dotted: upper bound on growth for as many decisions, by the corrected theory."
    yield from (
        (
            f"arrivals_by_reward_{end}",
            "arrivals",
            "Like the paper's Fig. 4, left. Mean over seeds and 95 % interval (band).",
            time_charts.arrivals_by_reward(arrived, scenario),
        ),
        (
            f"arrivals_by_architecture_{end}",
            "arrivals",
            "Like the paper's Fig. 4, right. Mean over seeds and 95 % interval (band).",
            time_charts.arrivals_by_architecture(arrived, scenario),
        ),
        (
            f"memory_{end}",
            "memory",
            "What the paper's Fig. 5 draws, m_L: entries of long-term memory, for SARSA of its "
            "table, m_Q, mean of all intersections. Every agent starts with its entries from the "
            "training phase.",
            time_charts.memory(recorded, scenario, "Memory", "mL, or mQ,"),
        ),
        (
            f"memory_growth_{end}",
            "memory",
            "The same, minus the entries present at the start: the paper compares these slopes.",
            time_charts.memory(grown, scenario, "Memory growth", "mL, or mQ, added"),
        ),
        (
            f"states_added_{end}",
            "memory",
            "The same with short-term memory, m_s + m_L (ours), which in a run this short is most "
            "of what dual memory adds. States per agent from start to end: "
            f"{_stored(results, tables.cells, preset, scenario)}.",
            time_charts.memory(entries, scenario, "Both memories", "ms + mL, or mQ, added"),
        ),
        (
            f"memory_size_{end}",
            "memory",
            "The paper's size, 3 m_L + |A| m_s values for dual memory and |A| m_Q for SARSA, added "
            "since the start." + (bounded if bounds else ""),
            time_charts.memory_size(sizes, scenario, bounds),
        ),
        (
            f"architectures_{end}",
            "architectures",
            "Every learning agent of the study. Grey lines: longest queue first and max-pressure "
            "in the same run.",
            cell_charts.all_architectures(tables.summary, preset, scenario),
        ),
    )


def _stored(results: Results, cells: Cells, preset: str, scenario: str) -> str:
    """Say how many states the agents of the memory figures store, at the start and at the end."""
    ends = results.query(
        f"""
        select {", ".join(CELL)}, time_s, avg({ENTRIES}) as mean, mean as low, mean as high
        from series where preset = '{preset}' and scenario = '{scenario}' and time_s in
            (select unnest([min(time_s), max(time_s)]) from series where scenario = '{scenario}')
        group by all order by time_s
        """
    )
    named = ends.join(cells.named, on=CELL, nulls_equal=True)
    lines, _ = time_charts.memory_lines(named)
    stored = dict(lines.group_by("line", maintain_order=True).agg("mean").rows())
    return "; ".join(
        f"{line} {stored[line][0]:,.0f} to {stored[line][-1]:,.0f}"
        for line in ordered(list(stored), ("SARSA exact", *PAPER_COLUMNS))
    )


def _memory_bounds(results: Results, scenario: str) -> Bounds | None:
    """Return the theory's bounds: |A| from SARSA's size and rows, the rest in the manifest."""
    if intersections_of(scenario) is None:
        return None  # intersections may differ in their actions
    actions = results.query(
        f"""
        select max(round(msize_per_agent / table_entries)) as actions from series
        where controller = 'sarsa' and table_entries > 0 and scenario = '{scenario}'
        """
    ).item()
    if actions is None:
        return None
    configuration = results.manifest.get("configuration", {})

    def setting(name: str) -> Any:
        return find_value(configuration, name, DualMemorySettings.model_fields[name].default)

    period = int(setting("stage_period"))
    ratio, least = float(setting("staged_ratio")), period or int(setting("short_capacity"))
    return partial(size_bounds, int(actions), ratio, least, rule="period" if period else "full")
