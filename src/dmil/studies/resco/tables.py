"""Tables of the study on the RESCO benchmark: scores, ranking, training, published; courses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import polars as pl

from dmil.analysis.estimates import (
    IQM,
    Values,
    as_column,
    interval_columns,
    learning_curve,
    ranking,
    seed_means,
)
from dmil.results import Results
from dmil.results.metrics import METRICS, SCORES
from dmil.seeding import stream
from dmil.statistics import (
    Estimate,
    mean_interval,
    paired_difference,
    standard_deviation,
    wins,
)
from dmil.studies.resco.agreement import agreement
from dmil.studies.resco.contenders import CONTENDER, REFERENCE, Judged, RescoContender, judged
from dmil.studies.resco.locks import locks
from dmil.studies.resco.published import (
    LAST_EPISODES,
    METRIC,
    PUBLISHED,
    counterpart_of,
    published_by,
)

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


@dataclass(frozen=True, slots=True)
class RescoTables:
    """What is known about a study on the benchmark: see the functions of these names."""

    judged: Judged
    scores: pl.DataFrame
    overall: pl.DataFrame
    training: pl.DataFrame
    agreement: pl.DataFrame
    headline: pl.DataFrame
    locks: pl.DataFrame


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
        locks(runs),
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
    known = published_by(scenario).items()
    learners = [(name, value.best_s) for name, value in known if value.last_s is not None]
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


def scores(runs: Judged) -> pl.DataFrame:
    """Return every metric of every contender, network and simulator (ours).

    Returns
    -------
    Columns ``scenario``, ``simulator``, those of a contender, ``metric``; ``n`` seeds, ``median``
    and ``worst`` of them; ``mean``, ``sd``, ``low`` and ``high`` (95 %); ``iqm``, the interquartile
    mean, with ``iqm_low`` and ``iqm_high``: one locked run in five does not move it; the paired
    ``difference`` of these to max-pressure's with its interval; ``share_better``, the share of
    seeds in which it is better than max-pressure, equal ones half; ``among_best``: whether the
    paired interval of its difference to the best interquartile mean does not show it to be worse
    (null with one seed).
    """
    return pl.concat(_of_metric(runs, metric) for metric in SCORES).filter(pl.col("n") > 0)


def _of_metric(runs: Judged, metric: str) -> pl.DataFrame:
    values = runs.measures[metric]
    shape = values.shape[:3]
    columns = values.reshape(-1, values.shape[3]).T
    found = mean_interval(columns, stream(0, "bootstrap", "resco", metric))
    rng = stream(0, "bootstrap", "resco", metric, "middle")
    middle = mean_interval(columns, rng, summary=IQM)
    frame = _places(runs).with_columns(
        metric=pl.lit(metric),
        n=pl.Series(found.seeds),
        **interval_columns(found),
        sd=as_column(standard_deviation(columns)),
        median=as_column(_medians(columns)),
        worst=as_column(_worst(columns, METRICS[metric].better)),
        **interval_columns(middle, "iqm", "iqm_{}"),
    )
    reference = runs.reference
    numbers = np.full(shape[:2], -1 if reference is None else reference)
    difference = _against(values, numbers, metric)
    frame = frame.with_columns(**interval_columns(difference, "difference", "difference_{}"))
    better = METRICS[metric].better
    sign = -1.0 if better == "more" else 1.0
    if better is None or reference is None:
        frame = frame.with_columns(share_better=pl.lit(None, pl.Float64))
    else:
        won = wins(sign * values, sign * values[:, :, [reference]])
        won[:, :, reference] = np.nan
        frame = frame.with_columns(share_better=as_column(seed_means(won, axis=-1).ravel()))
    if better is None:
        return frame.with_columns(among_best=pl.lit(None, pl.Boolean))
    means = sign * middle.value.reshape(shape)
    best = np.argmin(np.where(np.isnan(means), np.inf, means), axis=2)
    gap = _against(values, best, metric)
    worst_end = -gap.high if better == "more" else gap.low
    # Where nothing varies the interval has no width; a rounding error is no difference.
    unshown = as_column(worst_end) <= 1e-9
    return frame.with_columns(among_best=unshown)


def _against(values: Values, numbers: np.ndarray, metric: str) -> Estimate:
    """Return the paired difference of every contender to one of each network; -1 is none."""
    missing = np.full((*values.shape[:2], 1, values.shape[3]), np.nan)
    chosen = np.take_along_axis(
        np.concatenate([values, missing], axis=2), numbers[:, :, None, None], axis=2
    )
    seeds = values.shape[3]
    return paired_difference(
        values.reshape(-1, seeds).T,
        np.broadcast_to(chosen, values.shape).reshape(-1, seeds).T,
        stream(0, "bootstrap", "resco", metric, "difference"),
        summary=IQM,
    )


def _places(runs: Judged) -> pl.DataFrame:
    places = pl.DataFrame(
        [(name, simulator) for simulator in runs.simulators for name in runs.scenarios],
        schema=["scenario", "simulator"],
        orient="row",
    )
    return places.join(runs.keys, how="cross", maintain_order="left_right")


def _worst(columns: Values, better: str | None) -> Values:
    """Return the worst of (seeds, columns); NaN without any run."""
    sign = -1.0 if better == "more" else 1.0
    found: Values = np.where(np.isnan(columns), -np.inf, sign * columns).max(axis=0)
    return np.where(np.isinf(found), np.nan, sign * found)


def _medians(columns: Values) -> Values:
    """Return the medians of (seeds, columns), missing runs left out; NaN without any."""
    known = ~np.isnan(columns).all(axis=0)
    found = np.full(columns.shape[1], np.nan)
    found[known] = np.nanmedian(columns[:, known], axis=0)
    return found


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
