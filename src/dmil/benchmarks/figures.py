"""What a measurement of speed says."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class SpeedFigure:
    """One measured number, alone or beside another.

    Parameters
    ----------
    name
        What was measured.
    value
        Median over the repetitions, in ``unit``.
    unit
        Unit of the value, such as "ns" or "1/s".
    against
        Name of the figure that this one is compared with.
    ratio_median, ratio_min, ratio_max
        This one's value over the other's, over pairs measured one after the other.
    """

    name: str
    value: float
    unit: str
    against: str | None = None
    ratio_median: float | None = None
    ratio_min: float | None = None
    ratio_max: float | None = None
