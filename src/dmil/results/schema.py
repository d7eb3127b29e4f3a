"""The columns of a folder of results: one table, from which docs and checks are made.

Two tables make up the results of a study: ``runs`` (one row per run, its totals at the horizon) and
``series`` (one row per run and decision time). Columns that do not apply to a run are null: a
baseline has no reward, no exploration rate and no training; a failed run has no measures.
"""

from __future__ import annotations

from dataclasses import dataclass

import polars as pl

SCHEMA_VERSION = 1


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
        Unit in words, "" for names and flags.
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

_PRESET = Column("preset", _TEXT, "", "Reading of the paper: literal, decaying or matched.", False)
_SCENARIO = Column("scenario", _TEXT, "", 'Name of the scenario, such as "grid:5x5".', False)
_SEED = Column("seed", _WHOLE, "", "Master seed; equal seeds have equal demand.", False)
_CONTROLLER = Column(
    "controller",
    _TEXT,
    "",
    "sarsa, dual-memory, random, fixed-cycle, longest-queue-first, max-pressure.",
    False,
)
_EMBEDDING = Column("embedding", _TEXT, "", "exact, simple, complex, cells; null for baselines.")
_COMMUNICATION = Column(
    "communication", _FLAG, "", "Whether a central unit synchronises the memories.", False
)
_REWARD = Column(
    "reward", _TEXT, "", "default, diffusion, entropy, queue, pressure; null for baselines."
)
_EPSILON = Column(
    "epsilon", _REAL, "probability", "Exploration rate at time 0; null for baselines."
)

#: Columns of ``runs.parquet``.
RUNS: tuple[Column, ...] = (
    Column("study", _TEXT, "", "Name of the study.", False),
    _PRESET,
    _SCENARIO,
    _SEED,
    _CONTROLLER,
    _EMBEDDING,
    _COMMUNICATION,
    _REWARD,
    _EPSILON,
    Column("horizon_s", _WHOLE, "s", "Length of the run.", False),
    Column("training_s", _WHOLE, "s", "Length of the training before it; null for baselines."),
    Column("spawned_veh", _WHOLE, "vehicles", "Vehicles that entered until the horizon."),
    Column("arrived_veh", _WHOLE, "vehicles", "V_c: vehicles at their destination at the horizon."),
    Column("wait_veh_s", _WHOLE, "vehicle-seconds", "Queued vehicles summed over all steps."),
    Column("wait_per_spawned_s", _REAL, "s", "W: wait_veh_s / spawned_veh."),
    Column("w_over_vc", _REAL, "s per vehicle", "W / V_c at the horizon; the headline number."),
    Column("wait_per_visit_s", _REAL, "s", "wait_veh_s / visits of intersections."),
    Column("wait_per_arrived_s", _REAL, "s", "Mean waiting time of vehicles that arrived."),
    Column("mean_queue_veh", _REAL, "vehicles", "Queued vehicles in the network, mean over time."),
    Column(
        "travel_time_s",
        _REAL,
        "s",
        "Mean over spawned vehicles, those under way counted to the horizon.",
    ),
    Column("throughput_veh_per_h", _REAL, "vehicles per hour", "Arrived vehicles per hour."),
    Column("entries_per_agent", _REAL, "states", "Stored states at the horizon, mean over agents."),
    Column("entries_total", _WHOLE, "states", "Stored states, a shared table counted once."),
    Column("bytes_total", _WHOLE, "bytes", "True size of all memories."),
    Column(
        "msize_per_agent",
        _REAL,
        "values",
        "Paper's size: 3 m_L + |A| m_s, or |A| m_Q; mean over agents.",
    ),
    Column("status", _TEXT, "", '"ok", or the message of the failure.', False),
)

#: Columns of ``series.parquet``.
SERIES: tuple[Column, ...] = (
    _PRESET,
    _SCENARIO,
    _SEED,
    _CONTROLLER,
    _EMBEDDING,
    _COMMUNICATION,
    _REWARD,
    _EPSILON,
    Column("time_s", _WHOLE, "s", "Time of the decision, or the horizon.", False),
    Column("arrived_veh", _WHOLE, "vehicles", "V_c: vehicles at their destination by then."),
    Column("queue_veh", _WHOLE, "vehicles", "Queued vehicles in the network."),
    Column("short_term_entries", _REAL, "states", "m_s, mean over agents."),
    Column("long_term_entries", _REAL, "states", "m_L, mean over agents."),
    Column("table_entries", _REAL, "states", "m_Q, rows of the Q-table, mean over agents."),
    Column("bytes_total", _WHOLE, "bytes", "True size of all memories."),
    Column("msize_per_agent", _REAL, "values", "Paper's size of the memory, mean over agents."),
)

#: Column name to polars type, for ``pl.DataFrame(rows, schema=RUNS_SCHEMA)``.
RUNS_SCHEMA: dict[str, pl.DataType] = {column.name: column.dtype for column in RUNS}
SERIES_SCHEMA: dict[str, pl.DataType] = {column.name: column.dtype for column in SERIES}

#: What tells one run, and one row of a series, from all others.
RUN_KEY: tuple[str, ...] = (
    "study",
    "preset",
    "scenario",
    "seed",
    "controller",
    "embedding",
    "communication",
    "reward",
    "epsilon",
    "horizon_s",
)
SERIES_KEY: tuple[str, ...] = (
    "preset",
    "scenario",
    "seed",
    "controller",
    "embedding",
    "communication",
    "reward",
    "epsilon",
    "time_s",
)


def schema_markdown() -> str:
    """Return the documentation of both tables as Markdown (ours)."""
    lines = [f"Schema version {SCHEMA_VERSION}."]
    for title, columns in (("runs", RUNS), ("series", SERIES)):
        lines += ["", f"### `{title}.parquet`", "", "| column | type | unit | meaning |"]
        lines.append("|-|-|-|-|")
        lines += [f"| `{c.name}` | {c.dtype} | {c.unit} | {c.meaning} |" for c in columns]
    return "\n".join(lines) + "\n"
