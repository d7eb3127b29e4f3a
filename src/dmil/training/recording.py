"""Recorded runs: what observers saw, as tables in Parquet files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

from dmil.network import RoadNetwork
from dmil.results import write_recording
from dmil.training.flow import FlowRecorder
from dmil.training.loop import Run
from dmil.training.observers import Observer
from dmil.training.signal_events import EventRecorder, signal_table


class Recording:
    """Records runs on one network (ours).

    Attributes
    ----------
    observers: tuple of Observer
        Who has to watch each run.
    tables: dict of lists of frames
        Name of a table to its rows, a frame a run; see `dmil.results.schema.RECORDINGS`.
    """

    def __init__(self, network: RoadNetwork) -> None:
        self._network = network
        self._signals, self._flow = EventRecorder(), FlowRecorder()
        self.observers: tuple[Observer, ...] = (self._signals, self._flow)
        self.tables: dict[str, list[pl.DataFrame]] = {}

    def add(self, seed: int, result: Run) -> None:
        """Keep the run that has just ended.

        Parameters
        ----------
        seed
            Its seed.
        result
            What it came to, its memory watched.
        """
        measures, flow = result.measures, self._flow.flow
        ids = [item.id for item in self._network.intersections]
        columns: dict[str, pl.DataFrame] = {
            "seconds": pl.DataFrame(
                {
                    "time_s": range(1, measures.time_s + 1),
                    "arrived_veh": measures.arrived_at,
                    "queue_veh": measures.queued_at,
                }
            ),
            "series": pl.DataFrame(series_rows(result)),
            "flows": pl.DataFrame(
                {
                    "time_s": np.repeat(flow.time_s, len(ids)),
                    "intersection": ids * flow.time_s.size,
                    "queue_veh": flow.queue_veh.ravel(),
                    "passed_veh": flow.passed_veh.ravel(),
                }
            ),
            "signals": signal_table(self._signals.events, self._network),
        }
        for name, table in columns.items():
            self.tables.setdefault(name, []).append(table.with_columns(seed=pl.lit(seed)))

    def write(self, name: str, path: Path) -> None:
        """Write one table, as Parquet or CSV by the name of the file.

        Raises
        ------
        OutputError
            If it cannot be written.
        """
        write_recording(path, name, pl.concat(self.tables[name]))


def series_rows(result: Run) -> list[dict[str, Any]]:
    """Return a run as rows of ``series``: at every decision, if watched, and at the horizon."""
    measures = result.measures
    arrived = [0, *measures.arrived_at.tolist()]
    queued = [0, *measures.queued_at.tolist()]
    return [
        {
            "time_s": time_s,
            "arrived_veh": arrived[time_s],
            "queue_veh": queued[time_s],
            "short_term_entries": memory.short_term_entries,
            "long_term_entries": memory.long_term_entries,
            "table_entries": memory.table_entries,
            "bytes_total": memory.bytes_total,
            "msize_per_agent": memory.msize,
        }
        for time_s, memory in zip(result.time_s, result.memory, strict=True)
    ]
