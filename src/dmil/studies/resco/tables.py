"""Tables of the study on the RESCO benchmark: scores, overall standing, training, published."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import polars as pl

from dmil.analysis.estimates import interval_columns, ranking
from dmil.results import Results
from dmil.seeding import stream
from dmil.studies.resco.agreement import agreement
from dmil.studies.resco.contenders import REFERENCE, Judged, RescoContender, judged
from dmil.studies.resco.curves import learning_curves, training
from dmil.studies.resco.published import METHODS, METRIC, PUBLISHED, counterpart_of, published_by
from dmil.studies.resco.scores import scores


@dataclass(frozen=True, slots=True)
class RescoTables:
    """What is known about a study on the benchmark.

    Attributes
    ----------
    judged: Judged
        Its runs, arranged.
    scores, overall, training, agreement, headline: polars.DataFrame
        See the functions of these names.
    """

    judged: Judged
    scores: pl.DataFrame
    overall: pl.DataFrame
    training: pl.DataFrame
    agreement: pl.DataFrame
    headline: pl.DataFrame


def resco_tables(results: Results) -> RescoTables:
    """Compute all tables of a study on the RESCO benchmark (ours).

    Raises
    ------
    InputError
        No run succeeded.
    """
    runs = judged(results)
    table = scores(runs)
    return RescoTables(
        runs,
        table,
        overall(runs),
        training(learning_curves(results, runs)),
        agreement(runs),
        headline(table, runs.judge),
    )


def headline(table: pl.DataFrame, judge: str) -> pl.DataFrame:
    """Return the average delay where controllers are judged, with what was published (ours).

    Returns
    -------
    Rows of `scores` with ``published_method`` and ``published_s`` of the counterpart.
    """
    chosen = table.filter((pl.col("metric") == METRIC) & (pl.col("simulator") == judge))
    methods = [counterpart_of(name) for name in chosen["controller"]]
    values = [
        published_by(scenario)[method].best_s if method in published_by(scenario) else None
        for scenario, method in zip(chosen["scenario"], methods, strict=True)
    ]
    return chosen.with_columns(
        published_method=pl.Series(methods, dtype=pl.String),
        published_s=pl.Series(values, dtype=pl.Float64),
    )


def published_table() -> pl.DataFrame:
    """Return the published numbers, one row each (Ault and Sharon, 2021)."""
    rows = [(v.scenario, v.method, v.best_s, v.last_s) for v in PUBLISHED]
    return pl.DataFrame(
        rows, schema=["scenario", "method", "delay_s", "last_10_delay_s"], orient="row"
    )


def best_published_learner(scenario: str) -> tuple[str, float] | None:
    """Return method and delay of the best published learner of a scenario (ours)."""
    known = published_by(scenario)
    learners = [(name, known[name].best_s) for name in METHODS if name in known]
    learners = [each for each in learners if known[each[0]].last_s is not None]
    return min(learners, key=lambda each: each[1], default=None)


def overall(runs: Judged) -> pl.DataFrame:
    """Return how every contender stands against max-pressure over all networks (ours).

    Returns
    -------
    Per simulator and contender: ``scenarios``, ``n`` runs; ``ratio``, the interquartile mean over
    networks and seeds of its delay over that of max-pressure on the same vehicles, with its
    stratified bootstrap interval; ``share_better`` with interval, the share of runs in which its
    delay is less.
    """
    frames = []
    for simulator in runs.simulators:
        delays = runs.of(METRIC, simulator=simulator)
        base = runs.of(METRIC, simulator=simulator, contender=RescoContender(REFERENCE))
        tasks, bases = [task.T for task in delays], [each[:, None] for each in base]
        rng = stream(0, "bootstrap", "overall", simulator)
        over, ratio, better = ranking(tasks, bases, runs.reference, rng)
        columns = {
            "simulator": [simulator] * len(runs.names),
            "contender": runs.names,
            "scenarios": np.sum([(~np.isnan(task)).any(axis=0) for task in over], axis=0),
            "n": ratio.seeds,
            **interval_columns(ratio, "ratio"),
            **interval_columns(better, "share_better", "share_{}"),
        }
        frames.append(pl.DataFrame(columns).filter(pl.col("n") > 0))
    return pl.concat(frames)
