"""Courses over time: how learners learned, and how queues grew while controllers were judged."""

from __future__ import annotations

import polars as pl

from dmil.analysis.estimates import interval_columns, learning_curve
from dmil.results import Results
from dmil.seeding import stream
from dmil.statistics import mean_interval
from dmil.studies.resco.contenders import CONTENDER, Judged, RescoContender
from dmil.studies.resco.published import LAST_EPISODES

BIN_S = 60
"""Seconds that one point of a queue's course averages."""

_CURVE: dict[str, type[pl.DataType]] = {
    "scenario": pl.String,
    "contender": pl.String,
    "learner": pl.Int64,
    "trained_in": pl.String,
    "episode": pl.Int64,
    "n": pl.Int64,
    **dict.fromkeys(
        ("mean", "low", "high", "entries", "last", "last_low", "last_high"), pl.Float64
    ),
}

_BEST = {"episode": "best_episode", "mean": "best", "low": "best_low", "high": "best_high"}
_COURSE: dict[str, type[pl.DataType]] = {
    "contender": pl.String,
    **dict.fromkeys(("time_s", "mean", "low", "high"), pl.Float64),
}


def learning_curves(results: Results, runs: Judged, only: str | None = None) -> pl.DataFrame:
    """Return the average delay of every training episode, of all networks or one (ours).

    Returns
    -------
    Columns ``scenario``, ``contender``, ``learner`` (number of the contender), ``trained_in``,
    ``episode``, ``n``, ``mean``, ``low``, ``high``, ``entries`` (stored states per agent), and
    ``last``, ``last_low``, ``last_high``: of the mean over the last ten episodes, the same in all
    rows of a contender.
    """
    rows = results.query("from episodes")
    frames = []
    for scenario in runs.scenarios if only is None else [only]:
        for number, contender in enumerate(runs.contenders):
            own = rows.filter(pl.col("scenario") == scenario, *_is(contender))
            if own.height:
                key = {"scenario": scenario, "contender": runs.names[number], "learner": number}
                frames.append(_curve(own, key))
    return pl.concat(frames) if frames else pl.DataFrame(schema=_CURVE)


def training(curves: pl.DataFrame) -> pl.DataFrame:
    """Return the best episode and the mean of the last ten of every training (RESCO's summary).

    The best one is that with the lowest mean over seeds, as in the publication.

    Returns
    -------
    Columns ``scenario``, ``contender``, ``trained_in``, ``n`` seeds, ``episodes``;
    ``best_episode``, ``best`` with its interval; ``last`` with its interval, in s.
    """
    return (
        curves.sort("mean", "episode", nulls_last=True, maintain_order=True)
        .group_by("scenario", "learner", "contender", "trained_in", maintain_order=True)
        .agg(
            pl.col("n").max(),
            pl.len().alias("episodes"),
            pl.col("episode", "mean", "low", "high").first().name.map(_BEST.__getitem__),
            pl.col("last", "last_low", "last_high").first(),
        )
        .sort("scenario", "learner")
        .drop("learner")
    )


def queue_courses(results: Results, runs: Judged, scenario: str) -> pl.DataFrame:
    """Return the vehicles that wait over time, where controllers are judged (ours).

    Returns
    -------
    Columns ``contender``, ``time_s`` (middle of a minute), ``mean``, ``low``, ``high``.
    """
    keys = ", ".join(CONTENDER)
    name = scenario.replace("'", "''")
    rows = results.query(
        f"""
        select {keys}, seed, time_s // {BIN_S} as minute, avg(queue_veh) as queue_veh from series
        where scenario = '{name}' and simulator = '{runs.judge}' group by all
        """
    )
    frames = []
    for contender, label in zip(runs.contenders, runs.names, strict=True):
        own = rows.filter(_is(contender))
        if own.height:
            rng = stream(0, "bootstrap", "queues")
            minutes, _, found = learning_curve(own, "minute", "queue_veh", rng)
            times = [(minute + 0.5) * BIN_S for minute in minutes]
            frame = {"contender": label, "time_s": times} | interval_columns(found)
            frames.append(pl.DataFrame(frame))
    return pl.concat(frames) if frames else pl.DataFrame(schema=_COURSE)


def _is(contender: RescoContender) -> list[pl.Expr]:
    return [pl.col(name).eq_missing(getattr(contender, name)) for name in CONTENDER]


def _curve(own: pl.DataFrame, key: dict[str, object]) -> pl.DataFrame:
    """Return one learner's curve on one network."""
    rng = stream(0, "bootstrap", "training")
    episodes, values, found = learning_curve(own, "episode", "delay_s", rng)
    last = mean_interval(
        values[:, -LAST_EPISODES:].mean(axis=1, keepdims=True),
        stream(0, "bootstrap", "training", "last"),
    )
    entries = own.group_by("episode").agg(pl.col("entries_per_agent").mean()).sort("episode")
    frame = pl.DataFrame({"episode": episodes, "n": found.seeds}).with_columns(
        **interval_columns(found), entries=entries["entries_per_agent"]
    )
    ends = {name: column[0] for name, column in interval_columns(last, "last", "last_{}").items()}
    constant = key | ends | {"trained_in": own["trained_in"].first()}
    return frame.with_columns(
        **{name: pl.lit(value, _CURVE[name]) for name, value in constant.items()}
    ).select(pl.col(name).cast(dtype) for name, dtype in _CURVE.items())
