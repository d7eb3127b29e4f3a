"""What ``dmil evaluate`` says beside its tables: notes, one JSON object, a row per run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from itertools import groupby
from pathlib import Path
from typing import Any

import polars as pl

from dmil.cli.contenders import EvaluateParameters
from dmil.cli.measures import UNFINISHED, own_or_s
from dmil.controllers import CONTROLLERS
from dmil.demand import ResampledDemand
from dmil.demand.sumo.remarks import remarks_of
from dmil.experiments.answer import answer
from dmil.experiments.comparison import REFERENCE, Comparison
from dmil.files import write_atomically
from dmil.results.metrics import COMPARED
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

    Parameters
    ----------
    settings, found, scenario
        The command's, what came out, and where.
    others
        Policies that were trained elsewhere, as they are to be named.
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
        f"{own_or_s(timing.clearance_s)}, minimum green {own_or_s(timing.min_green_s)}."
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

    Raises
    ------
    OutputError
        It cannot be written.
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
