"""The report of a comparison on one scenario: what came out, how sure it is, and on which roads."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import altair as alt
import numpy as np
import polars as pl

from dmil.doctor import Diagnosis
from dmil.experiments.answer import METRIC, answer, locked_notes
from dmil.experiments.comparison import Comparison
from dmil.reports.export import embedded, figure, script_bundle, write_file
from dmil.reports.html import environment
from dmil.reports.marks import Chart, values
from dmil.reports.network_chart import network_chart
from dmil.reports.theme import DARK, FAINT, INK
from dmil.results.metrics import COMPARED, COMPARISON_PAGE, METRICS, Metric
from dmil.statistics import Estimate
from dmil.version import __version__

ROW_PX = 38
BROAD = 10.0
"""From this ratio between most and least on the axis is logarithmic, or a locked run hides all."""


def write_comparison(
    path: Path,
    found: Comparison,
    diagnosis: Diagnosis,
    *,
    title: str,
    about: Sequence[str],
    notes: Sequence[str],
) -> None:
    """Write a comparison as one page that works offline.

    Parameters
    ----------
    path, found, diagnosis
        The page, the comparison, and what the doctor says about the network and its demand.
    title
        Name of the scenario.
    about, notes
        How it was run, in a few words each, and how the numbers are to be read.

    Raises
    ------
    OutputError
        The file cannot be written.
    """
    seeds = "each dot is a seed, the black one the mean" if len(found.seeds) > 1 else "one seed"
    sure = "" if found.one_day or len(found.seeds) == 1 else ", the line its 95 % interval"
    ranking = figure(
        "ranking",
        "answer",
        title,
        f"Delay per vehicle, least first: {seeds}{sure}.",
        contenders_chart(found, METRIC, "delay, s per vehicle"),
    )
    caption = "The network; intersection numbers as in the list, colours by shape."
    chart = figure("network", "network", title, caption, network_chart(diagnosis))
    columns = [name for name in COMPARISON_PAGE if _is_known(found, name)]
    page = (
        environment()
        .get_template("comparison.html.j2")
        .render(
            title=title,
            about=about,
            notes=notes,
            answer=answer(found),
            withheld=found.withheld,
            locked=locked_notes(found),
            ranking=ranking,
            varies=_varies(found),
            answers=_answers(found),
            reference=found.reference
            if found.reference in found.labels and not found.withheld
            else None,
            columns=[(METRICS[name].column_head, name in COMPARED) for name in columns],
            rows=_rows(found, columns),
            findings=[each for each in diagnosis.findings if each.severity != "note"],
            figure=chart,
            specs=[(each.name, embedded(each.spec)) for each in (ranking, chart)],
            bundle=script_bundle(),
            dark_colours=DARK,
            version=__version__,
        )
    )
    write_file(path, page)


def _is_known(found: Comparison, metric: str) -> bool:
    values = found.measures[metric]
    return bool((values == values).any())


def _answers(found: Comparison) -> list[dict[str, Any]]:
    """Say of everyone whether the difference to the reference is shown, by its interval."""
    difference = found.difference(METRIC)
    if difference is None or found.withheld:
        return []
    answers = []
    for i, label in enumerate(found.labels):
        if label == found.reference:
            continue
        cell = _cell(difference, i, METRICS[METRIC])
        low, high = cell["low"], cell["high"]
        verdict = "one day, no interval" if found.one_day else "one seed shows nothing"
        if low is not None and high is not None:
            verdict = "less" if high < 0 else "more" if low > 0 else "no difference shown"
        answers.append({"label": label, "verdict": verdict, **cell})
    return answers


def _rows(found: Comparison, columns: Sequence[str]) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = [{"label": label, "cells": []} for label in found.labels]
    for name in columns:
        metric, mean = METRICS[name], found.mean(name)
        difference = found.difference(name) if name in COMPARED else None
        spread = list(found.spread(name).values()) if _varies(found) else []
        for i, row in enumerate(rows):
            is_other = row["label"] != found.reference
            row["cells"].append(
                {
                    "mean": _cell(mean, i, metric),
                    "spread": [float(each[i]) * metric.factor for each in spread],
                    "difference": _cell(difference, i, metric)
                    if difference is not None and is_other
                    else None,
                }
            )
    return rows


def _varies(found: Comparison) -> bool:
    """Tell whether there is more than one seed, and more than one day."""
    return len(found.seeds) > 1 and not found.one_day


def _cell(estimate: Estimate, i: int, metric: Metric) -> dict[str, Any]:
    ends = (estimate.value, estimate.low, estimate.high)
    value, low, high = (
        None if each[i] != each[i] else float(each[i]) * metric.factor for each in ends
    )
    return {"value": value, "low": low, "high": high, "digits": metric.digits}


def contenders_chart(found: Comparison, metric: str, title: str) -> Chart:
    """Draw a measure's means, intervals and seeds, in the order of the contenders.

    The title is that of its axis, with the unit.
    """
    measured, mean = found.measures[metric], found.mean(metric)
    known = measured[np.isfinite(measured) & (measured > 0)]
    broad = known.size > 0 and known.max() > BROAD * known.min()
    seeds = pl.DataFrame(
        [
            {"label": label, "seed": seed, "value": measured[k, i]}
            for i, label in enumerate(found.labels)
            for k, seed in enumerate(found.seeds)
            if measured[k, i] > 0 or not broad
        ],
        schema={"label": pl.String, "seed": pl.Int64, "value": pl.Float64},
    )
    means = pl.DataFrame(
        {"label": found.labels, "value": mean.value, "low": mean.low, "high": mean.high}
    ).fill_nan(None)
    scale = alt.Scale(type="log", nice=True) if broad else alt.Scale(zero=True)
    # A name's options on lines of their own leave the drawing its room on a phone.
    names = alt.Axis(labelExpr="split(datum.label, ',')", labelLimit=160, title=None)
    y = alt.Y("label:N", sort=None, axis=names)
    x = alt.X("value:Q", title=title, scale=scale, axis=alt.Axis(tickCount=5, format=",~f"))
    tip = [alt.Tooltip("label:N", title="controller"), alt.Tooltip("value:Q", format=".1f")]
    dots = alt.Chart(values(seeds)).mark_circle(color=FAINT, opacity=0.45, size=28)
    bars = alt.Chart(values(means.drop_nulls(["low", "high"]))).mark_rule(color=INK, strokeWidth=2)
    points = alt.Chart(values(means)).mark_point(color=INK, filled=True, size=70, opacity=1)
    return alt.layer(
        dots.encode(x=x, y=y, tooltip=[*tip, alt.Tooltip("seed:Q")]),
        bars.encode(x=alt.X("low:Q"), x2=alt.X2("high:Q"), y=y),
        points.encode(x=x, y=y, tooltip=tip),
    ).properties(width="container", height=ROW_PX * len(found.labels))
