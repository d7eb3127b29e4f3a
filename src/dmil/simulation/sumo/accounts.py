"""The measures of a run, from SUMO's output and from vehicles that are still in the network."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from dmil.demand import Vehicles
from dmil.simulation.measures import NAN, Measures
from dmil.simulation.sumo.approaches import (
    FloatArray,
    IntArray,
    RouteGeometry,
    passed_in_all,
    reached_stop_lines,
)

_ATTRIBUTE = re.compile(rb' (\w+)="([^"]*)"')
MG_PER_G = 1000.0

TRIP = ("id", "arrival", "departDelay", "timeLoss", "waitingTime", "waitingCount")
EMISSIONS = ("CO2_abs", "fuel_abs")
PERSON = ("depart", "waitingTime")


@dataclass(slots=True)
class Outputs:
    """Reads what SUMO appends to its file of trips (SUMO's documentation of "tripinfo").

    Vehicles whose id is no number SUMO drives beside those of the run; they do not count.

    Parameters
    ----------
    file
        The output of a run.
    """

    file: Path
    _read: int = 0
    _measured: bool = False
    _trips: list[list[float]] = field(default_factory=list)
    _standing_s: list[float] = field(default_factory=list)

    def update(self) -> None:
        """Read what is new in the file; a line that is not complete waits for the next time."""
        with self.file.open("rb") as file:
            file.seek(self._read)
            new = file.read()
        new = new[: new.rfind(b"\n") + 1]
        self._read += len(new)
        for kind, values in elements(new, b"tripinfo|emissions|personinfo"):
            if kind == b"tripinfo":
                self._measured = values[b"id"].isdigit()
                if self._measured:
                    self._trips.append([*_numbers(values, TRIP), 0.0, 0.0])
            elif kind == b"personinfo":
                depart_s, standing_s = _numbers(values, PERSON)
                if depart_s >= 0:  # SUMO writes about those to come, too
                    self._standing_s.append(standing_s)
            elif self._measured:
                self._trips[-1][-2:] = [mg / MG_PER_G for mg in _numbers(values, EMISSIONS)]

    @property
    def trips(self) -> FloatArray:
        """Vehicles that have ended: (vehicles, 8).

        Number, arrival time in SUMO's seconds, departure delay, time loss and time halting in s,
        stops, CO2 and fuel in g. After the run also those in the network, with arrival −1.
        """
        return np.array(self._trips).reshape(-1, len(TRIP) + len(EMISSIONS))

    @property
    def standing_s(self) -> FloatArray:
        """Seconds that persons stood still: (persons,); after the run also those under way."""
        return np.array(self._standing_s)


def _numbers(values: dict[bytes, bytes], names: tuple[str, ...]) -> tuple[float, ...]:
    return tuple(float(values[name.encode()]) for name in names)


def elements(text: bytes, names: bytes) -> Iterator[tuple[bytes, dict[bytes, bytes]]]:
    """Give name and attributes of all elements of some names (``a|b``), in their order."""
    for match in re.finditer(rb"<(" + names + rb") [^>]*>", text):
        yield match[1], dict(_ATTRIBUTE.findall(match[0]))


class Accounts:
    """Adds up a run.

    Parameters
    ----------
    output
        SUMO's output file.
    vehicles
        All journeys.
    begin_s
        SUMO's time at 0 s of the run.
    """

    def __init__(self, output: Path, vehicles: Vehicles, begin_s: int) -> None:
        self._outputs = Outputs(output)
        self._depart_s, self._begin_s = vehicles.depart_s, begin_s
        self._seen_s: list[int] = []
        self._halting_veh: list[int] = []

    def note_halting(self, time_s: int, halting_veh: int) -> None:
        """Note how many vehicles in the network halt at a decision (ours)."""
        self._seen_s.append(time_s)
        self._halting_veh.append(halting_veh)

    def measures(
        self,
        time_s: int,
        ways: RouteGeometry,
        seen: FloatArray,
        under_way: FloatArray,
        *,
        ended: bool,
        overruled: int,
        emissions: bool,
    ) -> Measures:
        """Return the measures up to now (definitions: `Measures`).

        Parameters
        ----------
        time_s
            Time since the run began.
        ways
            The routes of all vehicles, as SUMO last told them.
        seen: (5, vehicles in the network) float64
            Where they are, see `count_vehicles`.
        under_way: (vehicles in the network, 5) float64
            Number, departure delay, time loss, time halting and stops.
        ended
            Whether the output file tells about the vehicles in the network too.
        overruled
            Requests that the signal timing rules did not grant.
        emissions
            Whether SUMO's emission model runs.
        """
        if time_s:
            self._outputs.update()
        trips, standing_s = self._outputs.trips, self._outputs.standing_s
        done = trips[trips[:, 1] >= 0]
        ids, arrival_s = done[:, 0].astype(np.int64), done[:, 1] - self._begin_s
        spawned = int(np.searchsorted(self._depart_s, time_s))
        depart_s = self._depart_s[:spawned].astype(np.float64)
        # A vehicle that has neither arrived nor entered waits outside, from departure until now.
        delay_s = time_s - depart_s
        delay_s[ids] = done[:, 2]
        delay_s[under_way[:, 0].astype(np.int64)] = under_way[:, 1]
        # Only SUMO's output knows those that it is moving on out of a jam (teleports) at the end.
        unfinished = trips[trips[:, 1] < 0]
        delay_s[unfinished[:, 0].astype(np.int64)] = unfinished[:, 2]
        travel_s = time_s - depart_s
        travel_s[ids] = arrival_s - depart_s[ids]
        arrived_at = _count_until(arrival_s, time_s)
        entered_at = _count_until(depart_s + delay_s, time_s)
        outside_at = _count_until(depart_s, time_s) - entered_at
        return Measures(
            time_s=time_s,
            spawned_veh=spawned,
            arrived_veh=len(done),
            # Whole seconds: the mesoscopic model counts parts of them too.
            wait_veh_s=float(round(done[:, 4].sum() + under_way[:, 3].sum() + delay_s.sum())),
            visits=passed_in_all(ways, ids) + reached_stop_lines(ways, seen),
            arrived_wait_veh_s=float(round(done[:, [2, 4]].sum())),
            travel_veh_s=float(travel_s.sum()),
            time_loss_veh_s=float(trips[:, 3].sum() + (0 if ended else under_way[:, 2].sum())),
            departure_delay_veh_s=float(delay_s.sum()),
            stops=int(done[:, 5].sum() + under_way[:, 4].sum()),
            overruled=overruled,
            arrived_at=arrived_at,
            queued_at=outside_at + self._halting_at(time_s),
            co2_g=float(trips[:, 6].sum()) if emissions else NAN,
            fuel_g=float(trips[:, 7].sum()) if emissions else NAN,
            person_delay_s=float(standing_s.mean()) if standing_s.size else NAN,
        )

    def _halting_at(self, time_s: int) -> IntArray:
        """Return the vehicles that halt after every second, interpolated between decisions."""
        after_s = np.arange(1, time_s + 1)
        return np.rint(np.interp(after_s, self._seen_s, self._halting_veh)).astype(np.int32)


def _count_until(event_s: FloatArray, time_s: int) -> IntArray:
    """Return how many events there have been after every second (those at its end come later)."""
    return np.searchsorted(np.sort(event_s), np.arange(1, time_s + 1)).astype(np.int32)
