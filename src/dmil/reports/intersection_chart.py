"""One intersection as a picture: approaches, lanes, movements, all phases, its own program."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from dmil.doctor import Diagnosis, IntersectionFacts
from dmil.network import Intersection, RoadNetwork
from dmil.network.geometry import LANE_M, RoadGeometry, View
from dmil.network.lines import Points, beside, hull, inside
from dmil.reports.labels import counted
from dmil.reports.marks import Chart, heading
from dmil.reports.sheet import Sheet, shortened, text_width
from dmil.reports.theme import FAINT, GRID, INK

AHEAD_M = 2.5
"""How far ways across go on into the road that they lead to."""
AROUND_M = (9.0, 20.0)
"""How far the roads are shown beyond their stop lines: most of what lies between these, within
limits."""


class DrawnRoad(NamedTuple):
    """A piece of road: its middle line, (points, 2) in metres, and how many lanes it has."""

    line: Points
    lanes: int


class Crossing:
    """The geometry of one intersection.

    Attributes
    ----------
    low, high: (2,) float64
        Corners of the square that is shown.
    roads, others: list of DrawnRoad
        Links into and out of the intersection, and what else is in the square.
    ways: list of lists of (points, 2) float64 arrays
        For every movement the ways of its lanes.
    stops: dict of (str, int) to (2, 2) float64 array
        Link and lane to its stop line.
    hull: (corners, 2) float64
        The area between the stop lines.
    """

    def __init__(self, network: RoadNetwork, item: Intersection) -> None:
        self.geometry = geometry = RoadGeometry(network)
        self.stops = {
            (movement.from_link, lane): geometry.stop_line(movement.from_link, lane)
            for movement in item.movements
            for lane in movement.lanes
        }
        self.ways = [geometry.ways(movement, AHEAD_M) for movement in item.movements]
        ends = [point for stop in self.stops.values() for point in stop]
        ends += [way[-1] for ways in self.ways for way in ways]
        corners = np.array(ends)
        self.hull = hull(corners)
        middle = (corners.min(axis=0) + corners.max(axis=0)) / 2
        half = float(np.abs(corners - middle).max())
        half += float(np.clip(0.8 * half, *AROUND_M))
        self.low, self.high = middle - half, middle + half
        into, out_of = zip(
            *((each.from_link, each.to_link) for each in item.movements), strict=True
        )
        mine = tuple(dict.fromkeys(into + out_of))
        self.roads = [self._road(link) for link in mine]
        self.others = self._others(mine)

    def _road(self, link: str) -> DrawnRoad:
        return DrawnRoad(self.geometry.middle(link), self.geometry.links[link].lanes)

    def _others(self, mine: tuple[str, ...]) -> list[DrawnRoad]:
        """Return the other links in the square, and the ways across junctions without signals."""
        geometry = self.geometry
        near = [link for link in geometry.links if self._touches(geometry.course(link))]
        roads = [self._road(link) for link in near if link not in mine]
        ids = {*near, *mine}
        for junction in geometry.network.junctions:
            for movement in junction.movements:
                if {movement.from_link, movement.to_link} <= ids and movement.turn != "uturn":
                    here, there = self._road(movement.from_link), self._road(movement.to_link)
                    ends = np.array([here.line[-1], there.line[0]])
                    roads.append(DrawnRoad(ends, min(here.lanes, there.lanes)))
        return roads

    def _touches(self, points: Points) -> bool:
        outside = (points.max(axis=0) < self.low) | (points.min(axis=0) > self.high)
        return not outside.any() and bool(inside(points, self.low, self.high))


MAIN_PX, SIDE_PX, TOP_PX = 400, 132, 40
PHASE_PX, GAP_PX, HEAD_PX, MOST_COLUMNS = 196, 18, 36, 4
PROGRAM_PX, LEGEND_PX = 64, 26
ROAD, OTHER_ROAD, AREA, MARKING = "#dcdfe3", "#eef0f2", "#e4e7ea", "#ffffff"
GO, FREE, STOP = INK, "#0072B2", "#D55E00"
YIELD_DASH = (4, 3)


def intersection_chart(diagnosis: Diagnosis, index: int) -> Chart:
    """Draw the intersection of an index with its phases."""
    item, facts = diagnosis.case.network.intersections[index], diagnosis.intersections[index]
    crossing = Crossing(diagnosis.case.network, item)
    columns = min(max(len(item.phases), 3), MOST_COLUMNS)
    rows = -(-len(item.phases) // columns)
    width = max(MAIN_PX + 2 * SIDE_PX, columns * (PHASE_PX + GAP_PX) - GAP_PX)
    below = TOP_PX * 2 + MAIN_PX
    program_px = PROGRAM_PX if facts.stages else 0
    phases_px = rows * (PHASE_PX + HEAD_PX + GAP_PX)
    sheet = Sheet(width, below + LEGEND_PX + phases_px + program_px)
    _overview(sheet, crossing, item, facts, (width - MAIN_PX) / 2)
    _legend(sheet, item, below + 10)
    left = (width - columns * (PHASE_PX + GAP_PX) + GAP_PX) / 2
    for p in range(len(item.phases)):
        corner = (
            left + p % columns * (PHASE_PX + GAP_PX),
            below + LEGEND_PX + p // columns * (PHASE_PX + HEAD_PX + GAP_PX),
        )
        _phase(sheet, crossing, item, facts, p, corner)
    if facts.stages:
        _program(sheet, facts, below + LEGEND_PX + phases_px)
    several = f", one of {facts.alike}" if facts.alike > 1 else ""
    subtitle = (
        f"{counted(facts.movements, 'movement')}, {counted(len(facts.phases), 'phase')}; shape "
        f"{facts.shape}{several}; symmetry group of {facts.symmetries}; North is up"
    )
    name = shortened(facts.id, width - 150, 13)
    return sheet.chart(heading(f"{diagnosis.case.name}: {name}", subtitle))


class _Window:
    """Where the metres of a crossing are in a square of the picture."""

    def __init__(self, crossing: Crossing, left: float, top: float, size: float) -> None:
        self._low, self._high = crossing.low, crossing.high
        scale = size / float((self._high - self._low)[0])
        self.lane_px = LANE_M * scale
        self.place = View(self._low, scale, left, top + size).place

    def shown(self, points: Points) -> list[Points]:
        return [self.place(part) for part in inside(points, self._low, self._high)]


def _ground(sheet: Sheet, crossing: Crossing, frame: _Window) -> None:
    for road in crossing.others:
        for part in frame.shown(road.line):
            sheet.line(part, OTHER_ROAD, road.lanes * frame.lane_px)
    sheet.area(frame.place(crossing.hull), AREA)
    for road in crossing.roads:
        for part in frame.shown(road.line):
            sheet.line(part, ROAD, road.lanes * frame.lane_px)
    for road in crossing.roads:
        for part in frame.shown(
            beside(road.line, -road.lanes / 2 * LANE_M * crossing.geometry.side)
        ):
            sheet.line(part, MARKING, max(1.0, 0.12 * frame.lane_px))
    for road in crossing.roads:
        for k in range(1, road.lanes):
            for part in frame.shown(beside(road.line, (k - road.lanes / 2) * LANE_M)):
                sheet.line(part, MARKING, max(0.8, 0.08 * frame.lane_px), dash=(5, 4))


def _overview(
    sheet: Sheet, crossing: Crossing, item: Intersection, facts: IntersectionFacts, left: float
) -> None:
    frame = _Window(crossing, left, TOP_PX, MAIN_PX)
    _ground(sheet, crossing, frame)
    width = min(max(0.16 * frame.lane_px, 1.0), 1.8)
    for colour, free in ((FREE, True), (GO, False)):
        chosen = [j for j in range(len(item.movements)) if (j in item.unsignalled) == free]
        sheet.arrows(_placed(crossing, frame, chosen), colour, width)
    for stop in crossing.stops.values():
        sheet.line(frame.place(stop), FAINT, min(max(0.14 * frame.lane_px, 1.0), 3.5))
    _names(sheet, crossing, frame, facts, left)


def _placed(crossing: Crossing, frame: _Window, movements: Iterable[int]) -> list[Points]:
    return [frame.place(way) for j in sorted(movements) for way in crossing.ways[j]]


def _names(
    sheet: Sheet, crossing: Crossing, frame: _Window, facts: IntersectionFacts, left: float
) -> None:
    """Write the approaches around the picture, where their roads come in."""
    low = np.array([left, TOP_PX])
    middle = low + MAIN_PX / 2
    sides: dict[str, list[tuple[float, float, int]]] = {}
    for number, approach in enumerate(facts.approaches):
        parts = frame.shown(crossing.geometry.middle(approach.link))
        x, y = parts[0][0]
        across, down = (x - middle[0]) / MAIN_PX, (y - middle[1]) / MAIN_PX
        if abs(across) > abs(down):
            x, side = (x + 20, "left") if across > 0 else (x - 20, "right")
            sides.setdefault(side, []).append((y - 7, x, number))
        else:
            aside = 0.3 * approach.lanes * frame.lane_px
            inner = TOP_PX + 8 < y < TOP_PX + MAIN_PX - 8
            y += (14 if down > 0 else -24) + (np.copysign(aside, down) if inner else 0.0)
            sides.setdefault("center", []).append((y, x, number))
    for align, found in sides.items():
        found.sort()
        heights = [y for y, _, _ in found]
        for y, (_, x, number) in zip(
            heights if align == "center" else _spread(heights, 32.0), found, strict=True
        ):
            approach = facts.approaches[number]
            words = f"{approach.name} ({counted(approach.lanes, 'lane')})"
            sheet.text((x, y), words, 12, align=align, bold=True)
            link = shortened(approach.link, SIDE_PX - 26, 10)
            sheet.text((x, y + 13), link, 10, colour=FAINT, align=align)


def _spread(places: list[float], least: float) -> list[float]:
    """Move places, in order, so far apart that words fit between them."""
    for _ in range(40):
        for i in range(1, len(places)):
            gap = least - (places[i] - places[i - 1])
            if gap > 0:
                places[i] += gap / 2
                places[i - 1] -= gap / 2
    return places


def _phase(
    sheet: Sheet,
    crossing: Crossing,
    item: Intersection,
    facts: IntersectionFacts,
    p: int,
    corner: tuple[float, float],
) -> None:
    left, top = corner
    phase = facts.phases[p]
    room = PHASE_PX - 22
    sheet.text((left, top + 7), str(p), 12, bold=True, colour=FAINT)
    sheet.text((left + 16, top + 7), shortened(phase.name, room, 12), 12, bold=True)
    parts = []
    if facts.stages:
        green_s = phase.planned_green_s
        parts.append(f"{green_s:g} s green" if green_s is not None else "not in its program")
    if phase.load is not None:
        parts.append(f"needs {phase.load:.0%} of the time")
    sheet.text((left + 16, top + 22), ", ".join(parts), 10, colour=FAINT)
    frame = _Window(crossing, left, top + HEAD_PX, PHASE_PX)
    _ground(sheet, crossing, frame)
    green = item.phases[p]
    width = min(max(0.24 * frame.lane_px, 1.2), 2.2)
    gives_way = item.gives_way or ((),) * len(item.movements)
    yields = [j for j in green if not green.isdisjoint(gives_way[j])]
    sheet.arrows(_placed(crossing, frame, item.unsignalled), FREE, 0.7 * width)
    sheet.arrows(_placed(crossing, frame, yields), GO, width, dash=YIELD_DASH)
    sheet.arrows(_placed(crossing, frame, green.difference(yields)), GO, width)
    for lane in sorted(_stopped(item, green)):
        sheet.line(frame.place(crossing.stops[lane]), STOP, min(max(0.4 * frame.lane_px, 2.0), 3.2))


def _stopped(item: Intersection, green: frozenset[int]) -> set[tuple[str, int]]:
    """Return the lanes of which nobody may go."""
    lanes = [{(each.from_link, lane) for lane in each.lanes} for each in item.movements]
    free = [lanes[j] for j in green | item.unsignalled]
    return set().union(*lanes).difference(*free)


def _legend(sheet: Sheet, item: Intersection, y: float) -> None:
    x = 2.0
    entries: list[tuple[str, str, tuple[int, ...]]] = [("may go", GO, ())]
    if any(not phase.isdisjoint(foes) for phase in item.phases for foes in _foes(item, phase)):
        entries.append(("green, yields", GO, YIELD_DASH))
    if item.unsignalled:
        entries.append(("always open", FREE, ()))
    for words, colour, dash in entries:
        sheet.arrows([np.array([[x, y], [x + 15, y], [x + 28, y]])], colour, 1.6, dash=dash)
        sheet.text((x + 34, y), words, 10.5)
        x += 34 + text_width(words, 10.5) + 20
    sheet.line(np.array([[x + 8, y - 6], [x + 8, y + 6]]), STOP, 3.0)
    sheet.text((x + 16, y), "lane has red", 10.5)


def _foes(item: Intersection, phase: frozenset[int]) -> list[tuple[int, ...]]:
    return [item.gives_way[j] for j in phase] if item.gives_way else []


def _program(sheet: Sheet, facts: IntersectionFacts, top: float) -> None:
    """Draw one cycle of the own program as a bar, clearance in between."""
    words = f"Own program ({facts.program_kind}), cycle {facts.cycle_s:g} s; grey: no phase"
    sheet.text((0, top + 6), words, 11, bold=True)
    y, scale = top + 26, sheet.width / facts.cycle_s
    at_s = 0.0
    for seconds, phase in facts.stages:
        begin, end = at_s * scale, (at_s + seconds) * scale
        colour = GRID if phase is None else "#9db4c9" if phase % 2 else "#c5d3e0"
        sheet.line(np.array([[begin + 0.5, y], [end - 0.5, y]]), colour, 18)
        if phase is not None:
            sheet.text(((begin + end) / 2, y), str(phase), 11, align="center", bold=True)
        at_s += seconds
    step_s = next(step for step in (5, 10, 15, 30, 60, 120, 600) if facts.cycle_s / step <= 14)
    for tick in range(0, int(facts.cycle_s) + 1, step_s):
        x = tick * scale
        sheet.line(np.array([[x, y + 10], [x, y + 14]]), FAINT, 1)
        align = "left" if tick == 0 else "right" if x > sheet.width - 8 else "center"
        sheet.text((x, y + 22), f"{tick} s", 10, colour=FAINT, align=align)
