"""How numbers of a run are written in a terminal."""

from __future__ import annotations

UNFINISHED = (
    "Vehicles that have not arrived count with their travel and waiting time up to the end of the "
    "run."
)


def own_or_s(seconds: int | None) -> str:
    """Write a time of `dmil.scenarios.SignalTiming`: seconds, or that each plan tells."""
    return "as each plan says" if seconds is None else f"{seconds} s"


def number(value: float, digits: int, sign: str = "") -> str:
    """Return a number with a true minus sign, or a dash where there is none.

    Parameters
    ----------
    value, digits
        What to write, and how exactly.
    sign
        "+" for a sign before positive numbers, too.
    """
    return "–" if value != value else f"{value:{sign}.{digits}f}".replace("-", "−")
