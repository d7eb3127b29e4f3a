"""What a controller made the signals do: one event per phase change."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import polars as pl

from dmil.controllers import Controller
from dmil.network import RoadNetwork
from dmil.results.schema import RECORDINGS
from dmil.simulation import Observation, Simulator
from dmil.training.observers import Observer, Phases

SCHEMA = {name: kind for name, kind in RECORDINGS["signals"].schema.items() if name != "seed"}
NONE = -1
"""Phase before the first one, and while an intersection follows a program."""


@dataclass(frozen=True, slots=True)
class SignalEvent:
    """A change of phase at one intersection.

    Attributes
    ----------
    time_s: int
        When it began: the clearance of the phase before, if there is one.
    intersection: int
        Its index in the network.
    phase, from_phase: int
        Local numbers of the new and the former phase; −1 for none.
    green_from_s: int
        When the new phase turned green.
    green_before_s: int
        How long the former one had been green.
    overruled: int
        Requests that signal timing did not grant since the last event, this one's included.
    """

    time_s: int
    intersection: int
    phase: int
    from_phase: int
    green_from_s: int
    green_before_s: int
    overruled: int


class EventRecorder(Observer):
    """Notes what the signals do during a run (ours).

    Attributes
    ----------
    events: list of SignalEvent
        Those of the last run, in the order of time.
    """

    def __init__(self) -> None:
        self.events: list[SignalEvent] = []

    def begin(self, simulator: Simulator, controller: Controller, seen: Observation) -> None:
        """Forget the run before."""
        self.events = []
        count = seen.phase.size
        self._time_s = seen.time_s
        self._phase = np.full(count, NONE, np.int32)
        self._green_from_s = np.zeros(count, np.int64)
        self._overruled = np.zeros(count, np.int64)

    def advanced(self, phases: Phases, seen: Observation) -> None:
        """Note the changes of phase."""
        self._overruled += (np.asarray(phases) >= 0) & (phases != seen.phase)
        green_from_s = seen.time_s - seen.phase_elapsed_s
        for i in np.flatnonzero(seen.phase != self._phase).tolist():
            began = self._phase[i] != NONE
            self.events.append(
                SignalEvent(
                    time_s=self._time_s,
                    intersection=i,
                    phase=int(seen.phase[i]),
                    from_phase=int(self._phase[i]),
                    green_from_s=int(green_from_s[i]),
                    green_before_s=int(self._time_s - self._green_from_s[i]) if began else 0,
                    overruled=int(self._overruled[i]),
                )
            )
            self._green_from_s[i], self._overruled[i] = green_from_s[i], 0
        self._phase, self._time_s = seen.phase.copy(), seen.time_s


def signal_table(events: Sequence[SignalEvent], network: RoadNetwork) -> pl.DataFrame:
    """Return events, in the order of time, as ``signals`` of `RECORDINGS`, less the seed (ours)."""
    rows = []
    for event in events:
        item = network.intersections[event.intersection]
        rows.append(
            (
                event.time_s,
                item.id,
                None if event.phase == NONE else event.phase,
                dict(enumerate(item.phase_names)).get(event.phase) or None,
                None if event.from_phase == NONE else event.from_phase,
                event.green_from_s,
                event.green_before_s,
                event.overruled,
            )
        )
    return pl.DataFrame(rows, schema=SCHEMA, orient="row")
