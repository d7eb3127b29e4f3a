"""Figures of cells: all architectures, the paper beside ours, presets, against max-pressure.

Every function takes aggregated tables and returns a chart, or None without the runs for it.
"""

from __future__ import annotations

import altair as alt
import polars as pl

from dmil.analysis.panel import ordered
from dmil.reports.labels import architecture_label, colour, colours_by_label, controller_label
from dmil.reports.marks import (
    INTERVAL,
    RULES,
    Chart,
    coloured,
    diamonds,
    dots,
    heading,
    panels_across,
    panels_down,
    reference_rules,
    values,
)
from dmil.reports.theme import FAINT, INK, PANEL, PRESET_COLOURS, REWARD_COLOURS
from dmil.studies.paper.cells import BASELINES, REWARD_ORDER
from dmil.studies.paper.published import (
    COMPLEX,
    COMPLEX_COMMUNICATION,
    NO_MEMORY,
    PAPER_COLUMNS,
    SIMPLE,
    scenario_label,
)

_PANEL_ENDING = " reward"
_IN_PANEL = pl.col("reward") + _PANEL_ENDING
COLOURS: dict[str, str] = colours_by_label() | {
    NO_MEMORY: colour("sarsa"),
    SIMPLE: colour("dual-memory", ["simple"]),
    COMPLEX: colour("dual-memory"),
    COMPLEX_COMMUNICATION: colour("dual-memory"),
}
"""Colours of controllers and the paper's columns."""


def all_architectures(summary: pl.DataFrame, preset: str, scenario: str) -> Chart | None:
    """Draw W/V_c of every learning cell, baselines as reference lines."""
    learned = summary.filter(
        (pl.col("preset") == preset)
        & (pl.col("scenario") == scenario)
        & pl.col("reward").is_not_null()
    )
    if learned.is_empty():
        return None
    records = list(learned.iter_rows(named=True))
    data = learned.select(
        "n",
        panel=_IN_PANEL,
        mean="w_over_vc_mean",
        low="w_over_vc_low",
        high="w_over_vc_high",
        architecture=pl.Series([architecture_label(row) for row in records]),
        kind=pl.Series([f"{controller_label(r['controller'])} {r['embedding']}" for r in records]),
    )
    names = data["architecture"].unique(maintain_order=True).to_list()
    rewards = ordered(learned["reward"].unique().to_list(), REWARD_ORDER)
    kinds = data["kind"].unique(maintain_order=True).to_list()
    rules = _rules(summary, preset, scenario).join(
        pl.DataFrame({"panel": _panels(rewards)}), how="cross"
    )
    y = alt.Y("architecture:N", title=None, sort=names, axis=alt.Axis(grid=True, labelLimit=260))
    hue = coloured("kind", kinds, COLOURS)
    return (
        alt.layer(reference_rules(), *dots(y, hue))
        .properties(width=PANEL, height=15 * len(names))
        .facet(
            column=panels_across("panel", _panels(rewards)),
            data=values(pl.concat([data, rules], how="diagonal")),
        )
        .properties(
            title=heading(
                f"All architectures, {scenario_label(scenario)}, preset {preset}",
                "mean and 95 % interval over seeds; lower is better",
            )
        )
    )


def paper_against_ours(table: pl.DataFrame, preset: str) -> Chart | None:
    """Draw the paper's Table II beside ours, baselines as reference lines."""
    chosen = _with_label(table.filter(pl.col("preset") == preset))
    ours = chosen.filter(pl.col("column").is_in(PAPER_COLUMNS) & pl.col("mean").is_not_null())
    if ours.is_empty():
        return None
    rewards = ordered(ours["reward"].unique().to_list(), REWARD_ORDER)
    grids = ours["label"].unique(maintain_order=True).to_list()
    rules = (
        chosen.filter(pl.col("reward").is_null() & pl.col("mean").is_not_null())
        .with_columns(rule=_labelled("column", controller_label), rule_at="mean")
        .filter(pl.col("rule").is_in(RULES) & pl.col("label").is_in(grids))
        .select("label", "rule", "rule_at")
        .join(pl.DataFrame({"panel": _panels(rewards)}), how="cross")
    )
    kept = ours.select("label", "column", *INTERVAL, "paper_mean", panel=_IN_PANEL)
    order = list(PAPER_COLUMNS)
    y = alt.Y("column:N", title=None, sort=order, axis=alt.Axis(grid=True))
    hue = coloured("column", order, COLOURS)
    return (
        alt.layer(reference_rules(), *dots(y, hue), diamonds("paper_mean", y, "paper", 70))
        .properties(width=PANEL, height=72)
        .facet(
            row=panels_down("label", grids),
            column=panels_across("panel", _panels(rewards)),
            data=values(pl.concat([kept, rules], how="diagonal")),
        )
        .properties(
            title=heading(
                f"The paper's Table II (diamonds) and this run (dots), preset {preset}",
                "ours: mean and 95 % interval over seeds; lower is better",
            )
        )
    )


def against_max_pressure(summary: pl.DataFrame, preset: str) -> Chart | None:
    """Draw the paired difference of W/V_c to max-pressure: paper's columns and baselines."""
    chosen = summary.filter(
        (pl.col("preset") == preset) & pl.col("vs_max_pressure_pct").is_not_null()
    )
    named = [
        controller_label(row["controller"]) if row["reward"] is None else row["column"]
        for row in chosen.iter_rows(named=True)
    ]
    data = (
        _with_label(chosen.with_columns(name=pl.Series(named, dtype=pl.String)))
        .filter(pl.col("name").is_not_null() & (pl.col("controller") != "max-pressure"))
        .select(
            "name",
            "label",
            "n",
            reward=pl.col("reward").fill_null("none"),
            mean="vs_max_pressure_pct",
            low="vs_max_pressure_low_pct",
            high="vs_max_pressure_high_pct",
        )
    )
    if data.is_empty():
        return None
    rewards = ordered(data["reward"].unique().to_list(), (*REWARD_ORDER, "none"))
    learned = [name for name in rewards if name != "none"]
    # Baselines have one dot, which belongs in the middle of their row.
    middle = learned[len(learned) // 2] if learned else "none"
    data = data.with_columns(slot=pl.col("reward").replace({"none": middle}))
    order = [*PAPER_COLUMNS, *(controller_label(name) for name in BASELINES)]
    palette = {**REWARD_COLOURS, "none": INK}
    hue = coloured(
        "reward", rewards, palette, alt.Legend(title="reward", orient="bottom", titleOrient="left")
    )
    y = alt.Y("name:N", title=None, sort=order, axis=alt.Axis(grid=True))
    offset = alt.YOffset("slot:N", sort=learned or None)
    zero = alt.Chart().mark_rule(color=FAINT, strokeWidth=1).encode(x=alt.datum(0))
    grids = data["label"].unique(maintain_order=True).to_list()
    return (
        alt.layer(zero, *dots(y, hue, "W/Vc against max-pressure (%)", offset, "+.1f"))
        .properties(width=PANEL, height=alt.Step(8))
        .facet(column=panels_across("label", grids), data=values(data))
        .properties(
            title=heading(
                f"Waiting against max-pressure on the same seeds, preset {preset}",
                "paired difference and 95 % interval; below 0 is better than max-pressure",
            )
        )
    )


def preset_sensitivity(table: pl.DataFrame) -> Chart | None:
    """Draw W/V_c of the paper's columns under every preset."""
    presets = table["preset"].unique(maintain_order=True).to_list()
    if len(presets) < 2:
        return None
    data = _with_label(table).select("label", "column", "preset", *INTERVAL, panel=_IN_PANEL)
    rewards = ordered(table["reward"].unique().to_list(), REWARD_ORDER)
    grids = data["label"].unique(maintain_order=True).to_list()
    y = alt.Y("column:N", title=None, sort=list(PAPER_COLUMNS), axis=alt.Axis(grid=True))
    hue = coloured(
        "preset",
        presets,
        PRESET_COLOURS,
        alt.Legend(title="preset", orient="bottom", titleOrient="left"),
    )
    return (
        alt.layer(*dots(y, hue, offset=alt.YOffset("preset:N", sort=presets)))
        .properties(width=PANEL, height=alt.Step(7))
        .facet(
            row=panels_down("label", grids),
            column=panels_across("panel", _panels(rewards)),
            data=values(data),
        )
        .properties(
            title=heading(
                "Sensitivity to what the paper leaves open",
                "mean and 95 % interval over seeds under each preset; lower is better",
            )
        )
    )


def _rules(summary: pl.DataFrame, preset: str, scenario: str) -> pl.DataFrame:
    """Baselines as reference lines, from another preset if this one has none."""
    return (
        summary.filter(pl.col("reward").is_null() & (pl.col("scenario") == scenario))
        .sort(pl.col("preset") != preset, maintain_order=True)
        .unique("controller", keep="first", maintain_order=True)
        .select(rule=_labelled("controller", controller_label), rule_at="w_over_vc_mean")
        .filter(pl.col("rule").is_in(RULES))
    )


def _panels(rewards: list[str]) -> list[str]:
    return [reward + _PANEL_ENDING for reward in rewards]


def _with_label(table: pl.DataFrame) -> pl.DataFrame:
    return table.with_columns(label=_labelled("scenario", scenario_label))


def _labelled(column: str, label: object) -> pl.Expr:
    return pl.col(column).map_elements(label, return_dtype=pl.String)  # type: ignore[arg-type]
