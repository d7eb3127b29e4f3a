"""What ``dmil evaluate`` says: notes, one JSON object, a row per run, and its tables.

A table has a column per controller and a row per measure, with the differences, or is a ranking.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence
from dataclasses import asdict
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
from rich import box
from rich.table import Table
from rich.text import Text

from dmil.cli.controller_choice import EvaluateParameters
from dmil.cli.terminal import UNFINISHED, clearance, number, own_or_s
from dmil.controllers import CONTROLLERS
from dmil.demand import ResampledDemand
from dmil.demand.sumo.remarks import remarks_of
from dmil.experiments.answer import answer
from dmil.experiments.comparison import REFERENCE, Comparison
from dmil.files import write_atomically
from dmil.results.metrics import COMPARED, COMPARISON_TABLE, METRICS, Metric
from dmil.scenarios import Scenario
from dmil.scenarios.timing import advantages
from dmil.statistics import Estimate

PLANS = tuple(name for name, entry in CONTROLLERS.items() if entry.shows_plan)
"""Controllers that keep the times of the network's own plan, whatever others are given."""
NAMED = 3
"""How many intersections are named."""
UNDRIVABLE = ("unknown-road", "no-way", "one-road")
ONLINE = tuple(name for name, entry in CONTROLLERS.items() if entry.online)


def notes_of(
    settings: EvaluateParameters, found: Comparison, scenario: Scenario, others: list[str]
) -> list[str]:
    """Return how the numbers are to be read, a sentence or two each.

    ``others`` are the policies that were trained elsewhere, as they are to be named.
    """
    notes = [UNFINISHED]
    several = len(found.seeds) > 1
    if several and not found.one_day:
        notes.append(
            "Below each mean: 95 % bootstrap interval over seeds, then median, interquartile mean "
            "(IQM) and worst seed."
        )
    if found.same_demand:
        notes.append(
            "The vehicles are recorded, the same in every seed: one day, no interval. --resample "
            "draws similar days."
            if found.exact
            else "The vehicles are recorded, the same in every seed: one day. Seeds differ by "
            "SUMO's drivers and random choices of controllers; --resample draws other days."
        )
    elif isinstance(scenario.demand, ResampledDemand):
        notes.append(
            "Each seed is a day drawn from the recorded one: as many of its vehicles, shifted by "
            f"up to {scenario.demand.shift_s} s, the same for all controllers."
        )
    elif several:
        notes.append("Each seed has its own vehicles, the same for all controllers.")
    left_out = _left_out(scenario)
    if left_out:
        notes.append(
            f"Left out, because they cannot be simulated: {left_out} of the files' vehicles; dmil "
            "doctor says which."
        )
    if others:
        notes.append(f"Trained on something other than evaluated here: {', '.join(others)}.")
    entries = [CONTROLLERS.get(choice.name) for choice in settings.controller]
    online = [
        choice.label
        for choice, entry in zip(settings.controller, entries, strict=True)
        if entry and entry.online and choice.options.get("learning", True)
    ]
    if settings.baselines:
        online += [label for label in found.labels if label in ONLINE and label not in online]
    if online:
        notes.append(f"Untrained, learning from the first second: {', '.join(online)}.")
    if settings.policy or any(entry and entry.learns and not entry.online for entry in entries):
        epsilon = "their own" if settings.epsilon is None else f"{settings.epsilon:g}"
        frozen = f"frozen, ε = {settings.epsilon or 0:g}"
        notes.append(f"Learners: {f'learning, ε = {epsilon}' if settings.learn else frozen}.")
    timing = scenario.timing
    notes.append(
        f"Decisions every {timing.decision_interval_s} s, clearance "
        f"{clearance(timing)}, minimum green {own_or_s(timing.min_green_s)}."
    )
    return notes


def _left_out(scenario: Scenario) -> int:
    """Return how many vehicles the files have that this network has no way for."""
    remarks = remarks_of(scenario.demand)
    return sum(each.count for each in remarks if each.kind in UNDRIVABLE)


def unfair(scenario: Scenario, labels: Sequence[str]) -> str:
    """Return why a comparison with the network's own plan is not fair, else nothing."""
    names = {label.partition(",")[0] for label in labels}
    if names.isdisjoint(PLANS) or names <= set(PLANS):
        return ""
    found = groupby(
        advantages(scenario.timing, scenario.network), key=lambda each: each.intersection
    )
    items = scenario.network.intersections
    places = [f"{items[i].id}: {'; '.join(map(str, each))}" for i, each in found]
    if not places:
        return ""
    more = f" … and {len(places) - NAMED} more" if len(places) > NAMED else ""
    return (
        f"NOT A FAIR COMPARISON: at {len(places)} of {len(items)} intersections controllers have "
        f"shorter lost times than the plan ({' | '.join(places[:NAMED])}{more}), so no differences "
        "are shown. Omit --clearance, --all-red and --min-green: then all use the plan's times."
    )


def write_seeds(path: Path, found: Comparison) -> None:
    """Write every run as a row of a CSV: its measures, and what locked first in it.

    An `OutputError` if it cannot be written.
    """
    rows = []
    for k, seed in enumerate(found.seeds):
        for i, label in enumerate(found.labels):
            locked = found.locked.get((label, seed))
            values = {name: each[k, i] for name, each in found.measures.items()}
            rows.append(
                {
                    "seed": seed,
                    "controller": label,
                    **{name: None if value != value else value for name, value in values.items()},
                    "locked_junction": locked[0].junction if locked else None,
                    "locked_since_s": locked[0].since_s if locked else None,
                }
            )
    kinds: dict[str, Any] = dict.fromkeys(found.measures, pl.Float64)
    kinds |= {"locked_junction": pl.String, "locked_since_s": pl.Int64}
    write_atomically(path, pl.DataFrame(rows, schema_overrides=kinds).write_csv)


def as_json(found: Comparison, scenario: Scenario, notes: list[str]) -> dict[str, Any]:
    """Return a comparison as its JSON object."""
    means = {name: found.mean(name) for name in found.measures}
    spreads = {name: found.spread(name) for name in found.measures}
    references = dict.fromkeys((found.reference, REFERENCE))
    differences = {
        f"minus_{reference}": {name: found.difference(name, reference) for name in COMPARED}
        for reference in references
        if reference in found.labels or reference == found.reference
    }
    return {
        "scenario": scenario.name,
        "horizon_s": scenario.horizon_s,
        "seeds": list(found.seeds),
        "same_demand": found.same_demand,
        "withheld": found.withheld or None,
        "answer": answer(found),
        "controllers": [
            {
                "controller": label,
                "measures": {
                    name: _ends(each, i) | {key: of[i] for key, of in spreads[name].items()}
                    for name, each in means.items()
                },
                **{
                    minus: {name: _ends(each, i) for name, each in of.items() if each is not None}
                    for minus, of in differences.items()
                },
                "locked": [
                    {"seed": seed, **asdict(each)}
                    for (name, seed), runs in found.locked.items()
                    for each in runs
                    if name == label
                ],
                "per_seed": {
                    name: values[:, i].tolist() for name, values in found.measures.items()
                },
            }
            for i, label in enumerate(found.labels)
        ],
        "notes": notes,
    }


def _ends(estimate: Estimate, i: int) -> dict[str, float]:
    return {"mean": estimate.value[i], "low": estimate.low[i], "high": estimate.high[i]}


LABEL_WIDTH, COLUMN_WIDTH = 16, 20
SPREAD = "median IQM worst"
"""Label of how a measure varies over seeds: median, interquartile mean, worst seed."""


def ranking_table(found: Comparison, name: str) -> Table:
    """Return one metric of all contenders: how it varies over seeds, and the differences."""
    metric = METRICS[name]
    several = len(found.seeds) > 1 and not found.one_day
    mean, spread = found.mean(name), found.spread(name)
    difference = found.difference(name)
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, padding=(0, 1, 0, 0), pad_edge=False)
    table.add_column(", ".join(metric.short_label), width=COLUMN_WIDTH, overflow="fold")
    heads = ["mean", "median", "IQM", "worst"] if several else ["mean"]
    if difference is not None:
        heads.append(f"− {found.reference}")
    for head in heads:
        wide = COLUMN_WIDTH if head.startswith("−") else 0
        table.add_column("\n".join(_name_lines(head)), justify="right", min_width=wide)
    for i, label in enumerate(found.labels):
        cells = [_cell(mean, i, metric, plain=True)]
        if several:
            cells += [number(float(each[i]), metric.digits) for each in spread.values()]
        if difference is not None:
            same = label == found.reference
            cells.append("" if same else _cell(difference, i, metric, "+", apart=" "))
        table.add_row("\n".join(_name_lines(label)), *cells)
    return table


def _name_lines(label: str) -> list[str]:
    """Break a contender's name where its options begin, and between words where it is longer."""
    parts = re.split("(?<=[:,])", label)
    return [line for part in parts for line in textwrap.wrap(part, COLUMN_WIDTH)]


def comparison_table(found: Comparison, columns: range) -> Table:
    """Return means, intervals, how they vary over seeds, and differences to the reference.

    ``columns`` are those contenders that the terminal has room for.
    """
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, padding=0)
    table.add_column("", width=LABEL_WIDTH, no_wrap=True)
    for i in columns:
        head = "\n".join(_name_lines(found.labels[i]))
        table.add_column(head, width=COLUMN_WIDTH, justify="right", overflow="fold")
    several = len(found.seeds) > 1 and not found.one_day
    reference = "\n".join(textwrap.wrap(f"− {found.reference}", LABEL_WIDTH))
    for name in COMPARISON_TABLE:
        metric, values = METRICS[name], found.measures[name]
        if metric.optional and not np.nan_to_num(values).any():
            continue
        mean = found.mean(name)
        # What a frozen policy remembers is not a matter of chance.
        fixed = metric.optional and bool((values == values[0]).all())
        cells = (_cell(mean, i, metric, plain=fixed) for i in columns)
        table.add_row(_label(metric), *cells)
        if several and not fixed:
            spread = list(found.spread(name).values())
            cells = (
                " ".join(number(float(each[i]) * metric.factor, metric.digits) for each in spread)
                for i in columns
            )
            table.add_row(Text(SPREAD, "dim"), *cells)
        difference = found.difference(name) if name in COMPARED else None
        if difference is not None:
            cells = (
                _cell(difference, i, metric, "+") if found.labels[i] != found.reference else ""
                for i in columns
            )
            table.add_row(Text(reference, "dim"), *cells)
    return table


def _label(metric: Metric) -> Text:
    label, unit = metric.short_label
    return Text.assemble(label, "\n", (unit, "dim"))


def _cell(
    estimate: Estimate,
    i: int,
    metric: Metric,
    sign: str = "",
    *,
    plain: bool = False,
    apart: str = "\n",
) -> str:
    """Return a mean, and its interval on a second line unless that is not wanted."""
    value, low, high = (
        float(each[i]) * metric.factor for each in (estimate.value, estimate.low, estimate.high)
    )
    if value == 0 and not sign and (low == high == 0 or low != low):
        return "0"
    digits = metric.digits
    mean = number(value, digits, sign)
    return (
        mean
        if low != low or plain
        else f"{mean}{apart}[{number(low, digits)}, {number(high, digits)}]"
    )
