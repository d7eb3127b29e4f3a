"""When vehicles and flows depart: at listed times, or at random ones (SUMO docs: flows)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from dmil.demand.sumo.entry import Entry
from dmil.demand.vehicles import FloatArray

MOST_VEHICLES = 10**7
"""Most vehicles of one flow: more is a slip of the pen that would fill the memory."""
_RESOLUTION = 1000
"""SUMO rounds the part of a scale behind the point to thousandths, and counts time in them."""
_SPACINGS = ("period", "vehsPerHour", "perHour", "probability")


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
        """Return how often the next vehicle departs.

        Parameters
        ----------
        scale
            Product of the factors on it.
        """
        self._loaded += 1
        if scale == 1:
            return 1
        before = int(self._loaded / scale) if scale > 1 else self._loaded - 1
        share = math.floor((scale - int(scale)) * _RESOLUTION + 0.5)
        times = int(scale) + (before % _RESOLUTION * share % _RESOLUTION < share)
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
        """Draw departures before a time, in order.

        Parameters
        ----------
        until_s
            End of the run; of a flow with a given number all are drawn.
        rng
            Stream of random numbers.
        """
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


def departure_of_vehicle(entry: Entry, window: Window) -> Listed | None:
    """Return when a vehicle or trip departs, None if that is no fixed time.

    Raises
    ------
    DemandError
        If it has no departure, or it is neither a time nor one of SUMO's words.
    """
    text = entry.required("depart")
    if text in ("triggered", "containerTriggered", "split", "now"):
        return None
    if text == "begin":
        return Listed(np.array([window.begin_s]))
    return Listed(np.array([entry.seconds("depart")]))


def departures_of_flow(entry: Entry, window: Window, scale: float = 1.0) -> Listed | Drawn | None:
    """Return when a flow's vehicles depart, None if that is no fixed time.

    Parameters
    ----------
    entry
        The flow.
    window
        The part of SUMO's time that is simulated.
    scale
        Factor on their number: they depart more often between the same two times.

    Raises
    ------
    DemandError
        If its attributes contradict each other or do not suffice.
    """
    if entry.get("begin") in ("triggered", "containerTriggered"):
        return None
    begin_s = window.begin_s
    if entry.get("begin") not in (None, "begin"):
        begin_s = entry.seconds("begin") or 0.0
    number, spacing = _number(entry), _spacing(entry)
    _check_count(entry, (number or 0) * scale)
    end_s = _end_s(entry, begin_s, window, needed=spacing is None or number is None)
    if spacing is None:
        if number is None:
            raise entry.error(
                "it does not say how many vehicles depart",
                expected=f"number, or one of {', '.join(_SPACINGS)}",
            )
        period_s = math.floor((end_s - begin_s) * _RESOLUTION / max(number, 1)) / _RESOLUTION
        return _spaced(begin_s, period_s, number, scale)
    if entry.get("end") is not None and number is not None:
        raise entry.error(
            f"it has {spacing}, number and end", mend="remove number or end, as SUMO asks"
        )
    exponential = (entry.get("period") or "").startswith("exp(")
    if exponential or spacing == "probability":
        rate = _rate(entry, spacing) * (scale if exponential else 1)
        _check_count(entry, rate * scale * (end_s - begin_s) if number is None else 0)
        number = None if number is None else _rounded(number * scale)
        if not scale:
            return _spaced(begin_s, 0.0, 0, 1.0)
        each = 1.0 if exponential else scale
        return Drawn(begin_s, end_s, rate, not exponential, number, each)
    period_s = _period_s(entry, spacing)
    if number is None:
        _check_count(entry, scale * (end_s - begin_s) / period_s)
        number = max(0, math.ceil(round((end_s - begin_s) / period_s, 9)))
    scaled = _spaced(begin_s, period_s, number, scale)
    return scaled if scale == 1 else Listed(scaled.depart_s[scaled.depart_s < end_s])


def _spaced(begin_s: float, period_s: float, number: int, scale: float) -> Listed:
    """Return departures at equal distances; under a scale SUMO cuts these to whole ms."""
    if scale not in (0, 1):
        period_s = math.trunc(round(period_s * _RESOLUTION) / scale) / _RESOLUTION
    number = _rounded(number * scale)
    return Listed(begin_s + np.arange(number, dtype=np.float64) * period_s)


def _rounded(vehicles: float) -> int:
    return math.floor(vehicles + 0.5)


def _end_s(entry: Entry, begin_s: float, window: Window, *, needed: bool) -> float:
    end_s = entry.seconds("end", window.end_s)
    if end_s is None:
        if not needed:
            return math.inf
        raise entry.error(
            "it has no end, nor has the run",
            mend='add end="…" to it, or say how long a run lasts (--steps)',
        )
    if end_s < begin_s:
        if entry.get("end") is None:  # it begins after the run
            return begin_s
        raise entry.error(f"it ends at {end_s:g} s, before it begins at {begin_s:g} s")
    return end_s


def _number(entry: Entry) -> int | None:
    if entry.get("number") is None:
        return None
    value = entry.number("number", most=MOST_VEHICLES)
    if value != int(value):
        raise entry.error(f"number is '{entry.get('number')}'", expected="a whole number")
    return int(value)


def _spacing(entry: Entry) -> str | None:
    given = [name for name in _SPACINGS if entry.get(name) is not None]
    if len(given) > 1:
        raise entry.error(f"it has {' and '.join(given)}", expected="one of them")
    return given[0] if given else None


def _rate(entry: Entry, spacing: str) -> float:
    """Return the probability, or the rate of a Poisson process, per second."""
    text = entry.required(spacing)
    problem, expected = f"{spacing} is '{text}'", "a number above 0, at most 1"
    if spacing == "period":
        expected = "exp(rate) with a rate above 0 vehicles per second"
        text = text.removeprefix("exp(").removesuffix(")")
    try:
        rate = float(text)
    except ValueError:
        rate = math.nan
    if not (0 < rate < math.inf) or (spacing == "probability" and rate > 1):
        raise entry.error(problem, expected=expected)
    return rate


def _period_s(entry: Entry, spacing: str) -> float:
    if spacing == "period":
        period_s = entry.seconds("period")
    else:
        rate = entry.number(spacing)
        period_s = round(3600 / rate, 3) if rate > 0 else None  # SUMO counts in ms
    if not period_s:
        raise entry.error(f"{spacing} is '{entry.get(spacing)}'", expected="a number above 0")
    return period_s


def _check_count(entry: Entry, vehicles: float) -> None:
    if vehicles > MOST_VEHICLES:
        raise entry.error(
            f"it stands for {vehicles:.3g} vehicles",
            expected=f"at most {MOST_VEHICLES:,}",
            mend="correct its times",
        )
