"""When vehicles and flows depart: at listed times, or at random ones (SUMO docs: flows)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from dmil.demand.vehicles import FloatArray

RESOLUTION = 1000
"""SUMO rounds the part of a scale behind the point to thousandths, and counts time in them."""


@dataclass(frozen=True, slots=True)
class Window:
    """The part of SUMO's time that is simulated (ours).

    Parameters
    ----------
    begin_s
        Second that is second 0 of a run.
    end_s
        Where it ends; None if the files decide.
    """

    begin_s: float
    end_s: float | None


class Quota:
    """How often vehicles depart under a scale, one after the other (SUMO: ``getQuota``).

    The fraction is spread evenly over the vehicles in the order in which they are loaded, whatever
    their own factors are, so that nothing is random.
    """

    def __init__(self) -> None:
        self._loaded = 0

    def times(self, scale: float) -> int:
        """Return how often the next vehicle departs under the product of the factors on it."""
        self._loaded += 1
        if scale == 1:
            return 1
        before = int(self._loaded / scale) if scale > 1 else self._loaded - 1
        share = math.floor((scale - int(scale)) * RESOLUTION + 0.5)
        times = int(scale) + (before % RESOLUTION * share % RESOLUTION < share)
        self._loaded += max(times - 1, 0)
        return times


@dataclass(frozen=True, slots=True, eq=False)
class Listed:
    """Departures at fixed times (ours).

    Parameters
    ----------
    depart_s
        (departures,) float64, SUMO's seconds, non-decreasing.
    """

    depart_s: FloatArray

    @property
    def first_s(self) -> float:
        """First departure, infinite if there is none."""
        return float(self.depart_s[0]) if len(self.depart_s) else math.inf

    @property
    def last_s(self) -> float:
        """Last departure, minus infinity if there is none."""
        return float(self.depart_s[-1]) if len(self.depart_s) else -math.inf

    @property
    def mean_veh(self) -> float:
        """Number of departures."""
        return len(self.depart_s)

    def draw(self, until_s: float, rng: np.random.Generator) -> FloatArray:
        """Return the times; nothing is drawn."""
        return self.depart_s


@dataclass(frozen=True, slots=True)
class Drawn:
    """Departures at random (SUMO docs: ``probability`` and ``period="exp(rate)"`` of flows).

    Parameters
    ----------
    begin_s
        From when.
    end_s
        Up to this time, exclusive; infinite if the number ends it.
    rate_per_s
        Probability of a departure in every second, or mean departures per second.
    each_second
        Whether it is a probability.
    number
        How many departures there are; as many as fit if None.
    scale
        How many vehicles depart at each of those that are drawn second by second.
    """

    begin_s: float
    end_s: float
    rate_per_s: float
    each_second: bool
    number: int | None
    scale: float = 1.0

    @property
    def first_s(self) -> float:
        """Earliest possible departure."""
        return self.begin_s

    @property
    def last_s(self) -> float:
        """Latest departure that is to be expected."""
        if self.number is None:
            return self.end_s - 1
        return self.begin_s + self.number / self.rate_per_s

    @property
    def mean_veh(self) -> float:
        """Mean number of departures."""
        if self.number is None:
            return self.rate_per_s * (self.end_s - self.begin_s) * self.scale
        return self.number * min(self.scale, 1)

    def draw(self, until_s: float, rng: np.random.Generator) -> FloatArray:
        """Draw departures before a time, in order; of a flow with a given number all are drawn."""
        end_s = min(self.end_s, until_s)
        if self.each_second:
            return self._scaled(self._seconds(end_s, rng))
        if self.number is not None:
            return self.begin_s + np.cumsum(rng.exponential(1 / self.rate_per_s, self.number))
        count = rng.poisson(self.rate_per_s * max(0.0, end_s - self.begin_s))
        return np.sort(rng.uniform(self.begin_s, end_s, count))

    def _seconds(self, end_s: float, rng: np.random.Generator) -> FloatArray:
        """Draw the seconds in which somebody departs."""
        if self.number is not None:
            gaps = rng.geometric(self.rate_per_s, self.number).astype(np.float64)
            return math.ceil(self.begin_s) - 1 + np.cumsum(gaps)
        seconds = np.arange(math.ceil(self.begin_s), math.ceil(end_s), dtype=np.float64)
        return seconds[rng.random(len(seconds)) < self.rate_per_s]

    def _scaled(self, seconds: FloatArray) -> FloatArray:
        """Let as many depart in each second as the scale says, in all not more than the number."""
        if self.scale == 1:
            return seconds
        quota = Quota()
        times = [quota.times(self.scale) for _ in seconds]
        if self.number is not None:  # who does not depart counts as well
            enough = np.cumsum(np.maximum(times, 1)) - np.maximum(times, 1) < self.number
            times = list(np.asarray(times) * enough)
        return np.repeat(seconds, times)


def within(departures: Listed | Drawn, window: Window) -> tuple[Listed | Drawn, int, int]:
    """Leave out the departures before the beginning and those at or after the end (ours).

    Returns what is left, and how many were early and late; a flow that is drawn counts once.
    """
    begin_s = window.begin_s
    end_s = math.inf if window.end_s is None else window.end_s
    if isinstance(departures, Listed):
        times = departures.depart_s
        early, late = times < begin_s, np.ceil(times - begin_s) + begin_s >= end_s
        return Listed(times[~(early | late)]), int(np.sum(early)), int(np.sum(late))
    if departures.number is None and departures.end_s <= begin_s:
        return Listed(np.zeros(0)), 1, 0
    if departures.begin_s >= end_s:
        return Listed(np.zeros(0)), 0, 1
    if departures.number is not None:
        return departures, 0, 0
    # Neither kind of process remembers what was before the beginning.
    first_s, last_s = max(departures.begin_s, begin_s), min(departures.end_s, end_s)
    return replace(departures, begin_s=first_s, end_s=last_s), 0, 0


class Turns:
    """Divides departures among several kinds of vehicles, whoever is owed most goes next (ours).

    SUMO draws the kind of every vehicle anew in each run. Here it is settled once, since a way that
    was found for a bicycle is none for a car: evenly, so that in a run there are as many of each
    kind as there are in the mean of SUMO's, to within one. ``shares`` are the probabilities of the
    kinds; departures outside the run's window take turns of their own.
    """

    def __init__(self, shares: Sequence[float], window: Window) -> None:
        self._shares, self._window = np.array(shares), window
        self._owed, self._owed_outside = np.zeros((2, len(shares)))

    def share_out(self, departures: Listed | Drawn) -> list[Listed | Drawn]:
        """Return the departures of each kind, out of the next ones of all kinds together."""
        kinds = range(len(self._shares))
        if isinstance(departures, Listed):
            begin_s, end_s = self._window.begin_s, self._window.end_s
            times = departures.depart_s
            inside = (times >= begin_s) & (times < (np.inf if end_s is None else end_s))
            turns = np.empty(len(times), np.int64)
            turns[inside] = self._take(self._owed, int(inside.sum()))
            turns[~inside] = self._take(self._owed_outside, int((~inside).sum()))
            return [Listed(departures.depart_s[turns == k]) for k in kinds]
        rates = [departures.rate_per_s * share for share in self._shares.tolist()]
        if departures.number is None:
            return [replace(departures, rate_per_s=rate) for rate in rates]
        numbers = np.bincount(
            self._take(self._owed, departures.number), minlength=len(kinds)
        ).tolist()
        return [
            replace(departures, rate_per_s=rate, number=number) if number else Listed(np.zeros(0))
            for rate, number in zip(rates, numbers, strict=True)
        ]

    def _take(self, owed: FloatArray, count: int) -> npt.NDArray[np.int64]:
        """Return the kinds of the next vehicles."""
        turns = np.empty(count, np.int64)
        for vehicle in range(count):
            owed += self._shares
            turns[vehicle] = np.argmax(owed)
            owed[turns[vehicle]] -= 1
        return turns
