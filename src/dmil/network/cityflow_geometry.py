"""The shape of CityFlow's file, where its lanes run, and which ways across a junction cross.

The geometry is that of CityFlow's own engine (``Road::initLanesPoints``, ``RoadNet::loadFromJson``
and ``Intersection::initCrosses`` in its ``src/roadnet/roadnet.cpp``). Its points are complex
numbers: x to the East, y to the North, in metres.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated, Literal

import numpy as np
import numpy.typing as npt
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, NonNegativeInt

Text = Annotated[str, Field(min_length=1)]


class _Shape(BaseModel):
    model_config = ConfigDict(frozen=True)


class Point(_Shape):
    """A position in metres."""

    x: FiniteFloat
    y: FiniteFloat


class Lane(_Shape):
    """One lane of a road."""

    max_speed: Annotated[FiniteFloat, Field(gt=0, alias="maxSpeed")]
    width: Annotated[FiniteFloat, Field(ge=0)] = 4.0


class RoadnetRoad(_Shape):
    """A road in one direction."""

    id: Text
    points: Annotated[tuple[Point, ...], Field(min_length=2)]
    lanes: Annotated[tuple[Lane, ...], Field(min_length=1)]
    start: Annotated[Text, Field(alias="startIntersection")]
    end: Annotated[Text, Field(alias="endIntersection")]


class LaneLink(_Shape):
    """The way from a lane to a lane."""

    start_lane: Annotated[NonNegativeInt, Field(alias="startLaneIndex")]
    end_lane: Annotated[NonNegativeInt, Field(alias="endLaneIndex")] = 0
    points: tuple[Point, ...] | None = None


class RoadLink(_Shape):
    """The way from a road to a road."""

    type: Literal["go_straight", "turn_left", "turn_right", "turn_u"]
    start_road: Annotated[Text, Field(alias="startRoad")]
    end_road: Annotated[Text, Field(alias="endRoad")]
    lane_links: Annotated[tuple[LaneLink, ...], Field(min_length=1, alias="laneLinks")]


class LightPhase(_Shape):
    """A phase: road links that may go together, and for how long."""

    time: Annotated[FiniteFloat, Field(ge=0)]
    available: Annotated[tuple[NonNegativeInt, ...], Field(alias="availableRoadLinks")]


class TrafficLight(_Shape):
    """The signals of an intersection."""

    phases: Annotated[tuple[LightPhase, ...], Field(alias="lightphases")] = ()


class RoadnetIntersection(_Shape):
    """An intersection, or where it is virtual the end of the modelled roads."""

    id: Text
    point: Point
    width: Annotated[FiniteFloat, Field(ge=0)] = 0.0
    roads: tuple[Text, ...] | None = None
    road_links: Annotated[tuple[RoadLink, ...], Field(alias="roadLinks")] = ()
    light: Annotated[TrafficLight | None, Field(alias="trafficLight")] = None
    virtual: bool = False

    @property
    def is_fringe(self) -> bool:
        """Whether vehicles only begin and end here: CityFlow ignores a virtual one's links."""
        return self.virtual or not self.road_links


class RoadnetFile(_Shape):
    """The whole file."""

    intersections: tuple[RoadnetIntersection, ...]
    roads: tuple[RoadnetRoad, ...]


CURVE_STEPS = 10
"""Pieces of a way across a junction for which the file has no points."""
LEAST_BEND_M = 5.0
"""How far a vehicle at least goes straight on before it turns, where the junction has the room."""
TOLERANCE = 1e-9

Line = tuple[complex, ...]
Segments = npt.NDArray[np.complex128]


def road_length_m(road: RoadnetRoad, junctions: dict[str, RoadnetIntersection]) -> float:
    """Return the mean length of a road's lanes, without the junctions it joins (CityFlow).

    This is what CityFlow's router adds up. A junction that is missing, or virtual, takes nothing of
    the road.
    """
    ends = (junctions.get(node) for node in (road.start, road.end))
    start_m, end_m = (0.0 if node is None or node.virtual else node.width for node in ends)
    lengths = [_length_m(line) for line in _lanes(road, start_m, end_m)]
    return sum(lengths) / len(lengths)


def way_segments(link: RoadLink, roads: dict[str, RoadnetRoad], width_m: float) -> Segments:
    """Return begin and end of the pieces of a road link's ways: (2, pieces) complex128."""
    origin, destination = (_lanes(roads[name]) for name in (link.start_road, link.end_road))
    pieces = [
        piece
        for lane_link in link.lane_links
        for piece in pairwise(_way(lane_link, origin, destination, width_m))
    ]
    return np.array(pieces, dtype=np.complex128).reshape(-1, 2).T


def cross(one: Segments, other: Segments) -> bool:
    """Tell whether two ways cross or touch; ways that run along each other do not (CityFlow)."""
    here, step = one[0][:, None], (one[1] - one[0])[:, None]
    apart, their_step = other[0] - here, other[1] - other[0]
    area = _cross_product(step, their_step)
    slanted = np.abs(area) > TOLERANCE
    safe = np.where(slanted, area, 1.0)
    mine, theirs = (_cross_product(apart, each) / safe for each in (their_step, step))
    within = slanted
    for share in (mine, theirs):
        within = within & (share >= -TOLERANCE) & (share <= 1 + TOLERANCE)
    return bool(within.any())


def _cross_product(one: Segments, other: Segments) -> npt.NDArray[np.float64]:
    product: npt.NDArray[np.float64] = one.real * other.imag - one.imag * other.real
    return product


def _lanes(road: RoadnetRoad, start_m: float = 0.0, end_m: float = 0.0) -> list[Line]:
    """Return the middle line of every lane; the first is nearest to the road's points."""
    points = [complex(point.x, point.y) for point in road.points]
    points[0] += _unit(points[1] - points[0]) * start_m
    points[-1] -= _unit(points[-1] - points[-2]) * end_m
    steps = [_unit(there - here) for here, there in pairwise(points)]
    bends = [_unit(after + before) for before, after in pairwise(steps)]
    along = [steps[0], *bends, steps[-1]]
    lines, left_m = [], 0.0
    for lane in road.lanes:
        aside_m = (left_m + (left_m + lane.width)) / 2.0
        lines.append(
            tuple(point + u * -1j * aside_m for point, u in zip(points, along, strict=True))
        )
        left_m += lane.width
    return lines


def _way(link: LaneLink, origin: list[Line], destination: list[Line], width_m: float) -> Line:
    """Return a lane link's points: the file's, or else the curve that CityFlow lays."""
    if link.points:
        return tuple(complex(point.x, point.y) for point in link.points)
    lane = origin[link.start_lane]
    next_lane = destination[min(link.end_lane, len(destination) - 1)]
    start, ahead = _at(lane, _length_m(lane) - width_m)
    end, onward = _at(next_lane, width_m)
    half_m = abs(end - start) * 0.5
    bend_m = LEAST_BEND_M if half_m < LEAST_BEND_M <= width_m else half_m
    first, second = start + ahead * bend_m, end - onward * bend_m
    shares = [step / CURVE_STEPS for step in range(CURVE_STEPS + 1)]
    return tuple(
        (1 - s) ** 3 * start
        + 3 * (1 - s) ** 2 * s * first
        + 3 * (1 - s) * s**2 * second
        + s**3 * end
        for s in shares
    )


def _at(line: Line, distance_m: float) -> tuple[complex, complex]:
    """Return the point at a distance along a line, and the direction there."""
    left_m = min(max(distance_m, 0.0), _length_m(line))
    for here, there in pairwise(line):
        step_m = _norm(there - here)
        if left_m <= step_m and step_m > 0:
            return here + (there - here) * (left_m / step_m), _unit(there - here)
        left_m -= step_m
    return line[-1], _unit(line[-1] - line[-2])


def _length_m(line: Sequence[complex]) -> float:
    return sum(_norm(there - here) for here, there in pairwise(line))


def _norm(step: complex) -> float:
    # Not abs(): its last digit may differ from CityFlow's, and with it which of two ways is longer.
    return math.sqrt(step.real * step.real + step.imag * step.imag)


def _unit(step: complex) -> complex:
    length = _norm(step)
    return step / length if length else 0j
