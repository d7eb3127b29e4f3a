"""SUMO's output of a run: what happened to every vehicle, and how long persons stood."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

_ELEMENT = re.compile(rb"<(tripinfo|emissions|personinfo) [^>]*>")
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
        for match in _ELEMENT.finditer(new):
            values = dict(_ATTRIBUTE.findall(match[0]))
            if match[1] == b"tripinfo":
                self._measured = values[b"id"].isdigit()
                if self._measured:
                    self._trips.append([*_numbers(values, TRIP), 0.0, 0.0])
            elif match[1] == b"personinfo":
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
