"""How much of its time an intersection needs: critical movements, in the mean and at the peak."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.optimize import linprog

from dmil.network import Intersection

FloatArray = npt.NDArray[np.float64]

CYCLE_S = 120.0
"""Cycle that the lost times of a controller are spread over: the longest usual one."""


@dataclass(frozen=True, slots=True)
class Load:
    """What a demand asks of one intersection (ours).

    Parameters
    ----------
    flow_veh_per_h
        Vehicles per hour of every movement.
    phase_share
        Part of the time that every phase has to be green, at the division of time that needs
        least in all.
    degree
        Degree of saturation at best: that time, divided by what clearance leaves of a cycle of
        120 s. Above 1 the queues grow under every controller.
    program_degree
        Greatest degree of saturation of a lane under the own program, None without one; infinite
        if vehicles never have green.
    """

    flow_veh_per_h: tuple[float, ...]
    phase_share: tuple[float, ...]
    degree: float
    program_degree: float | None


def load_of(
    item: Intersection,
    flow_veh_per_s: FloatArray,
    saturation_veh_per_s: float,
    clearance_s: float,
) -> Load:
    """Compare flows with what the signals can serve (ours; critical movements as in the HCM).

    Vehicles spread over the lanes of their movement as evenly as the other movements there allow.
    Who gives way counts as if nobody were in the way, so real loads are somewhat higher.

    Parameters
    ----------
    item
        The intersection.
    flow_veh_per_s: (movements,) float64
    saturation_veh_per_s
        Saturation flow of a lane.
    clearance_s
        Clearance between two phases.
    """
    share = _least_green(item, flow_veh_per_s / saturation_veh_per_s)
    needed = float(share.sum())
    changes = int(np.sum(share > 1e-6))
    lost = clearance_s * changes / CYCLE_S if changes > 1 else 0.0
    return Load(
        flow_veh_per_h=tuple(3600 * flow_veh_per_s),
        phase_share=tuple(share.tolist()),
        degree=needed / max(1 - lost, 1e-6),
        program_degree=_under_program(item, flow_veh_per_s / saturation_veh_per_s),
    )


def _least_green(item: Intersection, ratio: FloatArray) -> FloatArray:
    """Divide the time among the phases so that all is served in the least time.

    Movements without a signal may go in the remaining time as well, which costs nothing.
    """
    greens = [*(phase | item.unsignalled for phase in item.phases), item.unsignalled]
    count = len(item.phases)
    cost = [1.0] * count + [0.0]
    most: list[float | None] = [*([None] * count), 1.0]
    found = _serve(item, greens, ratio, list(range(count + 1)), [1.0] * (count + 1), cost, most)
    return found[:count]


def _under_program(item: Intersection, ratio: FloatArray) -> float | None:
    """Return the least factor by which all greens would have to be longer to serve all."""
    if item.program is None:
        return None
    stages = item.program.stages
    greens = [stage.green | item.unsignalled for stage in stages]
    wanted = {j for j in range(len(item.movements)) if ratio[j] > 0}
    if not wanted <= frozenset().union(*greens):
        return float("inf")
    share = [stage.duration_s / item.program.cycle_s for stage in stages]
    return float(_serve(item, greens, ratio, [0] * len(stages), share, [1.0], [None])[0])


def _serve(
    item: Intersection,
    greens: Sequence[frozenset[int]],
    ratio: FloatArray,
    time: Sequence[int],
    factor: Sequence[float],
    cost: Sequence[float],
    most: Sequence[float | None],
) -> FloatArray:
    """Find times of least cost in which every movement is served.

    Parameters
    ----------
    item
        The intersection.
    greens
        Movements that may go in every stage.
    ratio
        (movements,) flow divided by a lane's saturation flow.
    time, factor
        A stage lasts for ``factor`` times this entry of the result.
    cost, most
        Of every entry of the result.
    """
    # A part is what one lane serves of a movement in a stage.
    parts = [
        (stage, j, item.movements[j].from_link, lane)
        for stage, green in enumerate(greens)
        for j in sorted(green)
        if ratio[j] > 0
        for lane in item.movements[j].lanes
    ]
    if not parts:
        return np.zeros(len(cost))
    first = len(cost)
    movements = {j: row for row, j in enumerate(dict.fromkeys(part[1] for part in parts))}
    lanes = {
        key: row
        for row, key in enumerate(dict.fromkeys((stage, *lane) for stage, _, *lane in parts))
    }
    served = np.zeros((len(movements), first + len(parts)))
    used = np.zeros((len(lanes), first + len(parts)))
    for column, (stage, j, *lane) in enumerate(parts, start=first):
        row = lanes[stage, *lane]
        served[movements[j], column] = 1.0
        used[row, column] = 1.0
        used[row, time[stage]] = -factor[stage]
    solved = linprog(
        [*cost, *([0.0] * len(parts))],
        A_ub=used,
        b_ub=np.zeros(len(lanes)),
        A_eq=served,
        b_eq=ratio[list(movements)],
        bounds=[(0, each) for each in (*most, *([None] * len(parts)))],
        method="highs",
    )
    return np.asarray(np.maximum(solved.x[:first], 0.0))
