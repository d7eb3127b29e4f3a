"""Departures of a vehicle or a flow, from its attributes (SUMO docs: flows)."""

from __future__ import annotations

import math

import numpy as np

from dmil.demand.sumo.departures import RESOLUTION, Drawn, Listed, Window
from dmil.demand.sumo.entry import DemandEntry
from dmil.errors import DemandError

MOST_VEHICLES = 10**7
"""Most vehicles of one flow: more is a slip of the pen that would fill the memory."""
_SPACINGS = ("period", "vehsPerHour", "perHour", "probability")


class EndlessError(DemandError):
    """A flow goes on for ever, since neither it nor the run has an end."""


def departure_of_vehicle(entry: DemandEntry, window: Window) -> Listed | None:
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


def departures_of_flow(
    entry: DemandEntry, window: Window, scale: float = 1.0
) -> Listed | Drawn | None:
    """Return when a flow's vehicles depart, None if that is no fixed time.

    Under a scale they depart more often between the same two times.

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
        period_s = math.floor((end_s - begin_s) * RESOLUTION / max(number, 1)) / RESOLUTION
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
        period_s = math.trunc(round(period_s * RESOLUTION) / scale) / RESOLUTION
    number = _rounded(number * scale)
    return Listed(begin_s + np.arange(number, dtype=np.float64) * period_s)


def _rounded(vehicles: float) -> int:
    return math.floor(vehicles + 0.5)


def _end_s(entry: DemandEntry, begin_s: float, window: Window, *, needed: bool) -> float:
    end_s = entry.seconds("end", window.end_s)
    if end_s is None:
        if not needed:
            return math.inf
        raise entry.error(
            "it has no end, nor has the run",
            mend='add end="…" to it, or say how long a run lasts (--steps)',
            kind=EndlessError,
        )
    if end_s < begin_s:
        if entry.get("end") is None:  # it begins after the run
            return begin_s
        raise entry.error(f"it ends at {end_s:g} s, before it begins at {begin_s:g} s")
    return end_s


def _number(entry: DemandEntry) -> int | None:
    if entry.get("number") is None:
        return None
    value = entry.number("number", most=MOST_VEHICLES)
    if value != int(value):
        raise entry.error(f"number is '{entry.get('number')}'", expected="a whole number")
    return int(value)


def _spacing(entry: DemandEntry) -> str | None:
    given = [name for name in _SPACINGS if entry.get(name) is not None]
    if len(given) > 1:
        raise entry.error(f"it has {' and '.join(given)}", expected="one of them")
    return given[0] if given else None


def _rate(entry: DemandEntry, spacing: str) -> float:
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


def _period_s(entry: DemandEntry, spacing: str) -> float:
    if spacing == "period":
        period_s = entry.seconds("period")
    else:
        rate = entry.number(spacing)
        period_s = round(3600 / rate, 3) if rate > 0 else None  # SUMO counts in ms
    if not period_s:
        raise entry.error(f"{spacing} is '{entry.get(spacing)}'", expected="a number above 0")
    return period_s


def _check_count(entry: DemandEntry, vehicles: float) -> None:
    if vehicles > MOST_VEHICLES:
        raise entry.error(
            f"it stands for {vehicles:.3g} vehicles",
            expected=f"at most {MOST_VEHICLES:,}",
            mend="correct its times",
        )
