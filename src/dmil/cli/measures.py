"""The measures of a run as people read them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Measure:
    """One row of a table.

    Parameters
    ----------
    name
        Column of the results.
    label
        What it is called.
    unit
        Its unit.
    digits
        Digits after the point.
    optional
        Whether it is left out where it is zero throughout, such as memory where there is none.
    factor
        What the results' number is multiplied with.
    """

    name: str
    label: str
    unit: str
    digits: int
    optional: bool = False
    factor: float = 1.0


MEASURES = (
    Measure("w_over_vc", "W/V_c", "s/veh", 4),
    Measure("wait_per_spawned_s", "W, wait per vehicle", "s", 2),
    Measure("wait_per_visit_s", "wait per intersection visit", "s", 2),
    Measure("wait_per_arrived_s", "wait of arrived vehicles", "s", 2),
    Measure("travel_time_s", "travel time", "s", 1),
    Measure("mean_queue_veh", "mean queue in the network", "veh", 2),
    Measure("throughput_veh_per_h", "throughput", "veh/h", 0),
    Measure("spawned_veh", "vehicles departed", "veh", 0),
    Measure("arrived_veh", "V_c, vehicles arrived", "veh", 0),
    Measure("entries_per_agent", "memory entries per intersection", "", 1, True),
    Measure("msize_per_agent", "memory size (paper's msize)", "values", 0, True),
    Measure("bytes_per_intersection", "memory per intersection", "bytes", 0, True),
    Measure("overruled", "phase requests overruled", "", 0, True),
)
"""All measures of a run (specification, §3)."""

UNFINISHED = (
    "Vehicles that have not arrived count, too: their travel and waiting time up to the end of the "
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
