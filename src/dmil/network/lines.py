"""Lines through points: moved aside, cut, bent, and what lies where along them.

A line is an array of points in their order, (points, 2) float64.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import numpy.typing as npt

Points = npt.NDArray[np.float64]
Point = tuple[float, float]
Line = tuple[Point, ...]

LOOK_M = 20.0
"""How far along a road its direction is taken: the last metres of a real one may be crooked."""


def beside(points: Points, distance: float) -> Points:
    """Move a line aside, to the right as seen along it with y to the North."""
    points = without_repeats(points)
    if len(points) < 2:
        return points
    along = np.diff(points, axis=0)
    along /= np.hypot(along[:, 0], along[:, 1])[:, None]
    normal = np.column_stack([along[:, 1], -along[:, 0]])
    before, after = np.vstack([normal[:1], normal]), np.vstack([normal, normal[-1:]])
    middle = before + after
    # Where the line bends, as far from both parts; a sharp bend is cut off.
    size = np.maximum((middle * middle).sum(axis=1), 1.0)
    return np.asarray(points + distance * middle * (2 / size)[:, None])


def without_repeats(points: Points, least: float = 1e-6) -> Points:
    """Leave out points that are nearer to the one before than a least distance.

    The first and the last one always stay.
    """
    kept = [points[0]]
    for point in points[1:-1]:
        if np.hypot(*(point - kept[-1])) > least:
            kept.append(point)
    if np.hypot(*(points[-1] - kept[-1])) > 1e-6:
        if len(kept) > 1 and np.hypot(*(points[-1] - kept[-1])) <= least:
            kept.pop()
        kept.append(points[-1])
    return np.array(kept)


def beginning(points: Points, length: float) -> Points:
    """Return the first part of a line, all of it if it is shorter."""
    kept, left = [points[0]], length
    for here, there in pairwise(points):
        step = float(np.hypot(*(there - here)))
        if step >= left:
            return np.array([*kept, here + (there - here) * (left / max(step, 1e-9))])
        kept.append(there)
        left -= step
    return points


def without_end(points: Points, length: float) -> Points:
    """Return a line less its last part, but at least a tenth of it."""
    whole = length_of(points)
    return beginning(points, max(whole - length, 0.1 * whole))


def inside(points: Points, low: Points, high: Points) -> list[Points]:
    """Return the parts of a line that are inside of a box with the corners ``low`` and ``high``."""
    parts: list[list[Points]] = []
    for here, there in pairwise(points):
        cut = _cut(here, there, low, high)
        if cut is None:
            continue
        first, last = cut
        if parts and np.allclose(parts[-1][-1], first):
            parts[-1].append(last)
        else:
            parts.append([first, last])
    return [np.array(part) for part in parts]


def _cut(here: Points, there: Points, low: Points, high: Points) -> tuple[Points, Points] | None:
    begin, end, way = 0.0, 1.0, there - here
    for axis in (0, 1):
        if abs(way[axis]) < 1e-12:
            if not low[axis] <= here[axis] <= high[axis]:
                return None
            continue
        one, other = (low[axis] - here[axis]) / way[axis], (high[axis] - here[axis]) / way[axis]
        begin, end = max(begin, min(one, other)), min(end, max(one, other))
    return (here + begin * way, here + end * way) if begin < end else None


def direction(points: Points, *, at_end: bool) -> Points:
    """Return the unit vector along a line at one of its ends."""
    way = points[-1] - points[-2] if at_end else points[1] - points[0]
    return np.asarray(way / max(float(np.hypot(*way)), 1e-9))


def bend_into(start: Points, goal: Points, least: float, beyond: float = 0.0) -> Points:
    """Return a smooth way from the end of one line to the beginning of another.

    It follows each of them for ``least`` at least, and goes on along the goal for ``beyond``.
    """
    first, last = start[-1], goal[0]
    reach = max(0.4 * math.dist(first, last), least)
    onward = direction(goal, at_end=False)
    ahead, back = first + direction(start, at_end=True) * reach, last - onward * reach
    t = np.linspace(0.0, 1.0, 17)[:, None]
    way = (1 - t) ** 3 * first + 3 * (1 - t) ** 2 * t * ahead
    way = np.asarray(way + 3 * (1 - t) * t**2 * back + t**3 * last)
    return np.vstack([way, way[-1] + onward * beyond]) if beyond else way


def length_of(points: Points) -> float:
    """Return the length of a line."""
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


def along(points: Points, distance: Points) -> tuple[Points, Points]:
    """Return what lies at some distances along a line.

    Parameters
    ----------
    points: (points, 2) float64
    distance: (places,) float64
        From its beginning; beyond its ends, as if it went on straight.

    Returns
    -------
    place: (places, 2) float64
    heading: (places,) float64
        Radians, counter-clockwise from East.
    """
    step = np.diff(points, axis=0)
    size = np.hypot(step[:, 0], step[:, 1])
    begin = np.cumsum(size) - size
    k = np.clip(np.searchsorted(begin, distance, side="right") - 1, 0, len(step) - 1)
    share = (distance - begin[k]) / np.maximum(size[k], 1e-9)
    return points[k] + step[k] * share[:, None], np.arctan2(step[k, 1], step[k, 0])


def heading(line: Sequence[Point]) -> float:
    """Return the angle, counter-clockwise from East, in which a line begins; 0 for no points."""
    if not line:
        return 0.0
    here, end, left_m = line[0], line[0], LOOK_M
    for point in line[1:]:
        step_m = math.dist(end, point)
        if step_m >= left_m:
            share = left_m / step_m
            end = (
                end[0] + share * (point[0] - end[0]),
                end[1] + share * (point[1] - end[1]),
            )
            break
        end, left_m = point, left_m - step_m
    return math.atan2(end[1] - here[1], end[0] - here[0])


def hull(points: Points) -> Points:
    """Return the corners of the smallest convex area around points, in order."""

    def half(ordered: list[tuple[float, float]]) -> list[tuple[float, float]]:
        kept: list[tuple[float, float]] = []
        for x, y in ordered:
            while len(kept) > 1:
                (ax, ay), (bx, by) = kept[-2:]
                if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0:
                    break
                kept.pop()
            kept.append((x, y))
        return kept[:-1]

    ordered = sorted({(float(x), float(y)) for x, y in points})
    return np.array([*half(ordered), *half(ordered[::-1])])
