"""All figures of the study on the RESCO benchmark, named, titled and explained."""

from __future__ import annotations

from collections.abc import Iterator

import polars as pl

from dmil.reports.export import Drawn, Figure, drawn_figures, slug
from dmil.reports.labels import simulator_label
from dmil.results import Results
from dmil.studies.resco import charts, network_charts
from dmil.studies.resco.contenders import JUDGES
from dmil.studies.resco.published import METRIC
from dmil.studies.resco.tables import (
    RescoTables,
    best_published_learner,
    learning_curves,
    queue_courses,
)

GOAL = 0.8
"""Kendall's τ that counts as agreement."""


def figures_of_study(tables: RescoTables) -> Iterator[Figure]:
    """Yield the figures of the main page that the runs allow (ours)."""
    judge = tables.judged.judge
    reference = tables.headline.filter(pl.col("controller") == "max-pressure")
    drawn: list[Drawn] = [
        (
            "delays",
            "headline",
            f"Every controller, learners frozen and greedy, in {simulator_label(judge)}. Dots: "
            "interquartile mean over seeds and 95 % interval; ticks: median. Diamonds: published "
            "values for the same kind of controller.",
            charts.delays(tables.headline, judge),
        ),
        (
            "locks",
            "locks",
            "Share of runs in which a junction locked. In the second protocol a vehicle that has "
            "stood on a junction for 10 s blocks nobody any more.",
            charts.locked_runs(tables.locks),
        ),
        (
            "simulators",
            "agreement",
            "Average delay of every controller on every network: in SUMO to the right, in the "
            "queue simulator upwards. Circles and diamonds learn, diamonds also communicate. "
            "SUMO's actuated control runs in SUMO only.",
            charts.simulators_scatter(tables.scores, judge),
        ),
        (
            "rank_agreement",
            "agreement",
            "Kendall's τ: 1 the same ranks, 0 no relation, −1 reversed. Intervals are over seeds; "
            "near 1 they can only reach down.",
            charts.rank_agreement(tables.agreement, GOAL),
        ),
        (
            "memory",
            "memory",
            "Delay relative to max-pressure's on the same network, over the true size of all "
            "agents' memories. Diamonds communicate.",
            charts.memory_and_delay(tables.scores, judge, reference),
        ),
    ]
    yield from drawn_figures(drawn)


def figures_of_network(results: Results, tables: RescoTables, scenario: str) -> Iterator[Figure]:
    """Yield the figures of one network's page that the runs allow (ours)."""
    runs = tables.judged
    curves = learning_curves(results, runs, scenario)
    drawn: list[Drawn] = [
        (
            "delay_by_simulator",
            "simulators",
            "Every controller, frozen and greedy, on the same vehicles in all simulators.",
            network_charts.delay_by_simulator(tables.scores, scenario),
        ),
        *(
            (
                "training" if trained_in not in JUDGES else "training_in_sumo",
                "training",
                f"Average delay of the training episodes in {simulator_label(trained_in)}. Level "
                "lines: max-pressure there, and the best episode of the best published learner, "
                "which was in SUMO.",
                network_charts.training_curves(
                    curves.filter(pl.col("trained_in") == trained_in),
                    scenario,
                    _rules(tables, scenario, trained_in),
                    trained_in,
                ),
            )
            for trained_in in runs.trained_in
        ),
        (
            "queues",
            "queues",
            "Vehicles that wait, those outside for room included. Random is left out: it would "
            "press all others together.",
            network_charts.queues(
                queue_courses(results, runs, scenario).filter(pl.col("contender") != "random"),
                scenario,
                runs.judge,
            ),
        ),
        (
            "memory",
            "memory",
            "Average delay against the true size of all agents' memories. Diamonds communicate.",
            network_charts.delay_and_memory(tables.scores, scenario, runs.judge),
        ),
    ]
    begin = slug(scenario.rpartition("/")[2])
    yield from drawn_figures([(f"{begin}_{each[0]}", *each[1:]) for each in drawn], scenario)


def _rules(tables: RescoTables, scenario: str, trained_in: str) -> dict[str, float]:
    """Return what the training is compared with."""
    rules = {}
    known = tables.scores.filter(
        (pl.col("scenario") == scenario)
        & (pl.col("simulator") == trained_in)
        & (pl.col("metric") == METRIC)
        & (pl.col("controller") == "max-pressure")
    )
    if known.height:
        rules["max-pressure"] = float(known["mean"].item())
    best = best_published_learner(scenario)
    if best:
        rules[f"published {best[0]}"] = best[1]
    return rules
