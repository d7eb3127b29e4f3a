"""Degree of saturation of an intersection: critical movements, on average and at the peak."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize import linprog

from dmil.network import Intersection

FloatArray = npt.NDArray[np.float64]

CYCLE_S = 120.0
"""Cycle that the lost times of a controller are spread over: the longest usual one."""


class VehicleStream(NamedTuple):
    """Vehicles that take one movement and may use the same lanes for it (ours).

    Attributes
    ----------
    movement
        Its local index.
    lanes
        Lanes of the link that it comes from.
    """

    movement: int
    lanes: tuple[int, ...]


Flows = Sequence[tuple[VehicleStream, float]]


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
    streams: Sequence[VehicleStream] | None = None,
) -> Load:
    """Compare flows with what the signals can serve (ours; critical movements as in the HCM).

    Vehicles spread over the lanes of their movement as evenly as the other movements there allow.
    Yielding vehicles count as if unopposed, so real loads are somewhat higher.

    Parameters
    ----------
    item
        The intersection.
    flow_veh_per_s: (streams,) float64
        Of every stream.
    saturation_veh_per_s
        Saturation flow of a lane.
    clearance_s
        Clearance between two phases.
    streams
        Who flows: the vehicles of a movement that may use some lanes; if not given, one stream per
        movement, in all of its lanes.
    """
    if streams is None:
        streams = [VehicleStream(j, movement.lanes) for j, movement in enumerate(item.movements)]
    flows = [
        (stream, ratio)
        for stream, ratio in zip(streams, flow_veh_per_s / saturation_veh_per_s, strict=True)
        if ratio > 0
    ]
    movement_veh_per_s = np.zeros(len(item.movements))
    np.add.at(movement_veh_per_s, [stream.movement for stream in streams], flow_veh_per_s)
    share = _least_green(item, flows)
    needed = float(share.sum())
    changes = int(np.sum(share > 1e-6))
    lost = clearance_s * changes / CYCLE_S if changes > 1 else 0.0
    return Load(
        flow_veh_per_h=tuple(3600 * movement_veh_per_s),
        phase_share=tuple(share.tolist()),
        degree=needed / max(1 - lost, 1e-6),
        program_degree=_under_program(item, flows),
    )


def _least_green(item: Intersection, flows: Flows) -> FloatArray:
    """Divide the time among the phases so that all is served in the least time.

    Movements without a signal may go in the remaining time as well, which costs nothing.
    """
    greens = [*(phase | item.unsignalled for phase in item.phases), item.unsignalled]
    count = len(item.phases)
    cost = [1.0] * count + [0.0]
    most: list[float | None] = [*([None] * count), 1.0]
    found = _serve(item, greens, flows, list(range(count + 1)), [1.0] * (count + 1), cost, most)
    return found[:count]


def _under_program(item: Intersection, flows: Flows) -> float | None:
    """Return the least factor by which all greens would have to be longer to serve all."""
    if item.program is None:
        return None
    stages = item.program.stages
    greens = [stage.green | item.unsignalled for stage in stages]
    wanted = {stream.movement for stream, _ in flows}
    if not wanted <= frozenset().union(*greens):
        return float("inf")
    share = [stage.duration_s / item.program.cycle_s for stage in stages]
    return float(_serve(item, greens, flows, [0] * len(stages), share, [1.0], [None])[0])


def _serve(
    item: Intersection,
    greens: Sequence[frozenset[int]],
    flows: Flows,
    time: Sequence[int],
    factor: Sequence[float],
    cost: Sequence[float],
    most: Sequence[float | None],
) -> FloatArray:
    """Find times of least cost in which every stream is served, as long as ``cost`` and ``most``.

    A stage of ``greens`` lasts for ``factor`` times that entry of the result which ``time`` names.
    Flows are divided by a lane's saturation flow.
    """
    # A part is what one lane serves of a stream in a stage.
    parts = [
        (stage, k, item.movements[stream.movement].from_link, lane)
        for stage, green in enumerate(greens)
        for k, (stream, _) in enumerate(flows)
        if stream.movement in green
        for lane in stream.lanes
    ]
    if not parts:
        return np.zeros(len(cost))
    first = len(cost)
    rows = {k: row for row, k in enumerate(dict.fromkeys(part[1] for part in parts))}
    lanes = {
        key: row
        for row, key in enumerate(dict.fromkeys((stage, *lane) for stage, _, *lane in parts))
    }
    served = np.zeros((len(rows), first + len(parts)))
    used = np.zeros((len(lanes), first + len(parts)))
    for column, (stage, k, *lane) in enumerate(parts, start=first):
        row = lanes[stage, *lane]
        served[rows[k], column] = 1.0
        used[row, column] = 1.0
        used[row, time[stage]] = -factor[stage]
    solved = linprog(
        [*cost, *([0.0] * len(parts))],
        A_ub=used,
        b_ub=np.zeros(len(lanes)),
        A_eq=served,
        b_eq=[flows[k][1] for k in rows],
        bounds=[(0, each) for each in (*most, *([None] * len(parts)))],
        method="highs",
    )
    return np.asarray(np.maximum(solved.x[:first], 0.0))
