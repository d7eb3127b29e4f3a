"""The columns of a folder of results: one table, from which docs and checks are made.

Five tables make up the results of a study: ``runs`` (one row per run, its totals at the horizon),
``series`` (one row per run and time), ``episodes`` (one row per training episode), ``lookups`` (one
row per run and source that memory was read from) and ``timings`` (one row per run: what it took on
this machine, the only table whose bytes differ from one execution to the next). Tables that a study
has no use for are empty. Columns that do not apply to a run are null: a baseline has no reward, no
exploration rate and no training; a failed run has no measures.
"""

from __future__ import annotations

from dataclasses import dataclass

import polars as pl

from dmil.results.metrics import EPISODE, METRICS

SCHEMA_VERSION = 7


@dataclass(frozen=True, slots=True)
class Column:
    """One documented column.

    Parameters
    ----------
    name
        Name, with its unit where it has one.
    dtype
        Polars type.
    unit
        Unit, "" for names, flags, and where the meaning says it.
    meaning
        One sentence.
    nullable
        Whether a row may leave it out.
    """

    name: str
    dtype: pl.DataType
    unit: str
    meaning: str
    nullable: bool = True


_TEXT, _FLAG, _WHOLE, _REAL = pl.String(), pl.Boolean(), pl.Int64(), pl.Float64()

_PRESET = Column(
    "preset",
    _TEXT,
    "",
    "Reading of the paper: literal, decaying or matched; resco; memories; ablation; capacity, "
    "disturbances.",
    False,
)
_SCENARIO = Column("scenario", _TEXT, "", 'Name of the scenario, such as "grid:5x5".', False)
_LOAD = Column(
    "load", _REAL, "", "Factor on the scenario's demand, where a study varies it from run to run."
)
_SEED = Column("seed", _WHOLE, "", "Master seed; equal seeds have equal demand.", False)
_CONTROLLER = Column(
    "controller",
    _TEXT,
    "",
    "Name of the controller; with options as in longest-queue-first,approaching=true.",
    False,
)
_SIMULATOR = Column(
    "simulator",
    _TEXT,
    "",
    "queue, queue-calibrated, sumo, sumo-meso, cityflow, or sumo-unblocked: SUMO with "
    "--ignore-junction-blocker 10.",
    False,
)
_TRAINED_IN = Column("trained_in", _TEXT, "", "Simulator of the training; null for baselines.")
_EMBEDDING = Column(
    "embedding", _TEXT, "", "exact, simple, complex, complex-scaled, cells; null for baselines."
)
_COMMUNICATION = Column(
    "communication", _FLAG, "", "Whether a central unit synchronises the memories.", False
)
_REWARD = Column(
    "reward", _TEXT, "", "default, diffusion, entropy, queue, pressure; null for baselines."
)
_EPSILON = Column(
    "epsilon", _REAL, "probability", "Exploration rate at time 0; null for baselines."
)

_VARIANT = Column(
    "variant",
    _TEXT,
    "",
    "One more option of the controller, as trigger=staging, or what disturbs the run, as incident; "
    "null for the paper's own, and undisturbed.",
)

_WHO = (
    *(_PRESET, _SCENARIO, _LOAD, _SEED, _CONTROLLER),
    *(_EMBEDDING, _COMMUNICATION, _REWARD, _EPSILON),
)
_METRICS = {
    name: Column(name, _WHOLE if each.whole else _REAL, each.unit, each.meaning)
    for name, each in METRICS.items()
    if each.stored
}

#: Columns of ``runs.parquet``.
RUNS: tuple[Column, ...] = (
    Column("study", _TEXT, "", "Name of the study.", False),
    *_WHO,
    _VARIANT,
    _SIMULATOR,
    _TRAINED_IN,
    Column("horizon_s", _WHOLE, "s", "Length of the run.", False),
    Column("training_s", _WHOLE, "s", "Length of the training before it; null for baselines."),
    *(column for name, column in _METRICS.items() if name != "msize_per_agent"),
    Column("intersections", _WHOLE, "", "Intersections that the controller decides for."),
    Column(
        "locked",
        _WHOLE,
        "intersections",
        "Intersections that locked: from some second to the end a queue, and less than a fifth of "
        "those cross who would if nobody waited. Null where it was not looked for.",
    ),
    Column("locked_from_s", _WHOLE, "s", "When the first of them locked; null for none."),
    _METRICS["msize_per_agent"],
    Column(
        "decisions_until_better",
        _WHOLE,
        "decisions",
        "From the first decision of its training, or of the run, until its queue stays below "
        "max-pressure's; null if it never does, and for controllers that do not learn.",
    ),
    Column(
        "growth",
        _REAL,
        "share",
        "Share of the arrivals by which the vehicles waiting grow in the second half of the run; "
        "in the study of capacity.",
    ),
    Column(
        "recovery_s",
        _REAL,
        "s",
        "From the end of a disturbance until about as many vehicles wait as without it, up to the "
        "end of the run.",
    ),
    Column("status", _TEXT, "", '"ok", or the message of the failure.', False),
)

#: Columns of ``series.parquet``.
SERIES: tuple[Column, ...] = (
    *_WHO,
    _VARIANT,
    _SIMULATOR,
    Column("time_s", _WHOLE, "s", "Time of the decision, or the horizon.", False),
    Column("arrived_veh", _WHOLE, "vehicles", "V_c: vehicles at their destination by then."),
    Column("queue_veh", _WHOLE, "vehicles", "Queued vehicles in the network."),
    Column("short_term_entries", _REAL, "states", "m_s, mean over agents."),
    Column("long_term_entries", _REAL, "states", "m_L, mean over agents."),
    Column("table_entries", _REAL, "states", "m_Q, rows of the Q-table, mean over agents."),
    Column("bytes_total", _WHOLE, "bytes", "True size of all memories."),
    Column("msize_per_agent", _REAL, "values", "Paper's size of the memory, mean over agents."),
)

#: Columns of ``episodes.parquet``.
EPISODES: tuple[Column, ...] = (
    *_WHO,
    _TRAINED_IN,
    Column("episode", _WHOLE, "", "Number of the training episode, from 0.", False),
    *(_METRICS[name] for name in EPISODE),
)

_RUN = (*_WHO, _SIMULATOR)

#: Columns of ``lookups.parquet``.
LOOKUPS: tuple[Column, ...] = (
    *_RUN,
    Column("source", _TEXT, "", "Where the value came from, such as short-term or prior.", False),
    Column("lookups", _WHOLE, "look-ups", "How often, in the run.", False),
)

#: Columns of ``timings.parquet``.
TIMINGS: tuple[Column, ...] = (
    *_RUN,
    Column("decisions", _WHOLE, "decisions", "Decisions of the run, each for all intersections."),
    Column("decide_s", _REAL, "s", "Time that they took, learning included."),
    Column("training_wall_s", _REAL, "s", "Time that the training took; null without one."),
)

#: Column name to polars type, for ``pl.DataFrame(rows, schema=RUNS_SCHEMA)``.
RUNS_SCHEMA: dict[str, pl.DataType] = {column.name: column.dtype for column in RUNS}
SERIES_SCHEMA: dict[str, pl.DataType] = {column.name: column.dtype for column in SERIES}


def _key(columns: tuple[Column, ...], last: str) -> tuple[str, ...]:
    names = [column.name for column in columns]
    return tuple(names[: names.index(last) + 1])


#: What tells one run, and one row of another table, from all others.
RUN_KEY = _key(RUNS, "horizon_s")
SERIES_KEY = _key(SERIES, "time_s")
EPISODES_KEY = _key(EPISODES, "episode")
LOOKUPS_KEY = _key(LOOKUPS, "source")
TIMINGS_KEY = _key(TIMINGS, "simulator")


@dataclass(frozen=True, slots=True)
class Table:
    """One table of results, in a file of its name.

    Parameters
    ----------
    columns
        Its columns in order.
    key
        Columns that tell its rows apart, and by which they are sorted; none: they stay as they are.
    """

    columns: tuple[Column, ...]
    key: tuple[str, ...] = ()

    @property
    def schema(self) -> dict[str, pl.DataType]:
        """Column name to polars type."""
        return {column.name: column.dtype for column in self.columns}


TABLES: dict[str, Table] = {
    "runs": Table(RUNS, RUN_KEY),
    "series": Table(SERIES, SERIES_KEY),
    "episodes": Table(EPISODES, EPISODES_KEY),
    "lookups": Table(LOOKUPS, LOOKUPS_KEY),
    "timings": Table(TIMINGS, TIMINGS_KEY),
}
"""All tables by name; the file of each is its name with the ending .parquet."""


_TIME = Column("time_s", _WHOLE, "s", "Time since the run began.", False)
_WHERE = Column("intersection", _TEXT, "", "Id of the intersection.", False)

RECORDINGS: dict[str, Table] = {
    "seconds": Table((_SEED, _TIME, *SERIES[-7:-5])),
    "series": Table((_SEED, *SERIES[-8:])),
    "flows": Table(
        (
            _SEED,
            _TIME,
            _WHERE,
            Column("queue_veh", _WHOLE, "vehicles", "Vehicles that wait before it."),
            Column("passed_veh", _WHOLE, "vehicles", "Those that have crossed it until then."),
        )
    ),
    "signals": Table(
        (
            _SEED,
            Column("time_s", _WHOLE, "s", "When the phase began, its clearance first.", False),
            _WHERE,
            Column("phase", _WHOLE, "", "Number of the new phase, from 0; null for a program."),
            Column("phase_name", _TEXT, "", "Its name; null where it has none."),
            Column("from_phase", _WHOLE, "", "Number of the former phase; null for none."),
            Column("green_from_s", _WHOLE, "s", "When the new phase turned green."),
            Column("green_before_s", _WHOLE, "s", "How long the former one had been green."),
            Column(
                "overruled",
                _WHOLE,
                "requests",
                "Requests that signal timing did not grant since the last event, with this one's.",
            ),
        )
    ),
    "training": Table(
        (
            Column("episode", _WHOLE, "", "Number of the training episode, from 1.", False),
            Column("decisions", _WHOLE, "decisions", "Decisions, each for all intersections."),
            *(_METRICS[name] for name in (*EPISODE, "w_over_vc", "arrived_veh")),
            Column("reward_sum", _REAL, "", "Rewards of all intersections, summed."),
            Column("epsilon", _REAL, "probability", "Exploration rate after it; null for none."),
        )
    ),
}
"""Tables of recorded runs by name, rows in the order of time."""


def schema_markdown() -> str:
    """Return the documentation of all tables as Markdown."""
    files = {f"{name}.parquet": table for name, table in TABLES.items()} | RECORDINGS
    lines = [f"Schema version {SCHEMA_VERSION}."]
    for title, table in files.items():
        lines += ["", f"### `{title}`", "", "| column | type | unit | meaning |"]
        lines.append("|-|-|-|-|")
        lines += [f"| `{c.name}` | {c.dtype} | {c.unit} | {c.meaning} |" for c in table.columns]
    return "\n".join(lines) + "\n"
