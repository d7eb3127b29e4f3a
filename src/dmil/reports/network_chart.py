"""A network as a picture: roads by lanes and speed, intersections by shape."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from dmil.doctor import Diagnosis, IntersectionFacts
from dmil.network import RoadNetwork
from dmil.network.geometry import LANE_M, RoadGeometry, fitted, road_ends
from dmil.network.lines import Points, beside, without_repeats
from dmil.reports.labels import counted
from dmil.reports.marks import Chart, heading
from dmil.reports.sheet import Sheet, shortened, text_width
from dmil.reports.theme import FAINT, INK
from dmil.scenarios.names import shown

LONGEST_PX, LEAST_PX, MARGIN_PX = 680, 150, 26
LIST_PX, ROW_PX, FOOT_PX = 250, 15, 58
MOST_LISTED = 48
"""Of more intersections only the shapes are listed."""
THINNEST_LANE_PX, WIDEST_LANE_PX, ROUND_UP_TO_PX = 0.9, 3.0, 6.0
SPEEDS_KM_PER_H = ((30, "#c3ccd6"), (50, "#8fa1b5"), (70, "#566f8a"), (math.inf, "#24384d"))
"""Up to which limit a road has which colour."""
SHAPE_COLOURS = (*("#0072B2", "#D55E00", "#00795A", "#AA3377", "#7A5C00", "#5B4FB0", "#CC79A7"),)
ALONE, ANOTHER = "#3a3a3a", "#858585"
"""Of shapes that only one intersection has, and of further shapes of several ones."""


def network_chart(diagnosis: Diagnosis) -> Chart:
    """Draw a network."""
    facts = diagnosis.network
    frame = _Frame(diagnosis.case.network)
    rows = _listed(diagnosis)
    map_px = frame.size_px
    height = max(map_px[1] + FOOT_PX, len(rows) * ROW_PX + 12)
    sheet = Sheet(map_px[0] + LIST_PX, height)
    _roads(sheet, diagnosis, frame)
    _nodes(sheet, diagnosis, frame)
    _foot(sheet, diagnosis, frame)
    _list(sheet, rows, map_px[0] + 14)
    subtitle = (
        f"{counted(facts.intersections, 'intersection')} of {counted(facts.shapes, 'shape')}; "
        f"{facts.links} links, {facts.road_km:.1f} km; North is up"
    )
    return sheet.chart(heading(shown(diagnosis.case.name), subtitle))


class _Frame:
    """Where metres are in the picture."""

    def __init__(self, network: RoadNetwork) -> None:
        self.geometry = RoadGeometry(network)
        lines = [self.geometry.course(link.id) for link in network.links]
        points = np.vstack([*lines, list(network.position_m.values())])
        view, self.size_px = fitted(points, LONGEST_PX, MARGIN_PX, LEAST_PX)
        self.place, self.scale = view.place, view.scale
        self.lane_px = min(max(LANE_M * self.scale, THINNEST_LANE_PX), WIDEST_LANE_PX)


def _roads(sheet: Sheet, diagnosis: Diagnosis, frame: _Frame) -> None:
    case, geometry = diagnosis.case, frame.geometry
    # Fast and wide roads lie above others.
    for link in sorted(case.network.links, key=lambda link: (link.speed_m_per_s, link.lanes)):
        line_px = without_repeats(frame.place(geometry.course(link.id)), 1.5)
        if len(line_px) < 2:
            continue
        width = link.lanes * frame.lane_px
        # The picture's y goes down, so the right of the road is at its left.
        line_px = beside(line_px, -geometry.side * (width / 2 + 0.4))
        speed = 3.6 * link.speed_m_per_s
        colour = next(colour for most, colour in SPEEDS_KM_PER_H if round(speed) <= most)
        tip = {
            "link": link.id,
            "lanes": str(link.lanes),
            "length": f"{link.length_m:.0f} m",
            "speed": f"{speed:.0f} km/h",
        }
        sheet.line(
            line_px, colour, width, cap="round" if width <= ROUND_UP_TO_PX else "butt", tip=tip
        )


def _nodes(sheet: Sheet, diagnosis: Diagnosis, frame: _Frame) -> None:
    network = diagnosis.case.network
    crossed = [each for each in network.junctions if each.id not in road_ends(network)]
    few = len(crossed) <= 150
    for junction in crossed:
        place = frame.place(network.position_m[junction.id]).tolist()
        sheet.dot(place, 1.7 if few else 1.1, "white", rim=FAINT, rim_width=0.6)
    for node in sorted(diagnosis.ends):
        place = frame.place(network.position_m[node]).tolist()
        sheet.dot(place, 2.6, "white", rim=INK, rim_width=1.1)
    colours = _colours(diagnosis)
    places = frame.place([network.position_m[each.id] for each in network.intersections])
    radius = 9.0 if len(places) <= 40 else 6.0
    labels = apart(places, 2 * radius + 1)
    for place, label in zip(places, labels, strict=True):
        if np.hypot(*(place - label)) > 0.5 * radius:
            sheet.line(np.array([place, label]), INK, 1.0)
            sheet.dot(place, 2.2, INK)
    for number, (label, item) in enumerate(
        zip(labels, diagnosis.intersections, strict=True), start=1
    ):
        sheet.dot(
            label, radius, colours[item.shape], rim="white", rim_width=1.4, tip=_tip(number, item)
        )
    if radius > 6:
        for number, label in enumerate(labels, start=1):
            sheet.text(label, str(number), 10.5, colour="white", align="center", bold=True)


def _tip(number: int, item: IntersectionFacts) -> dict[str, str]:
    return {
        "number": str(number),
        "id": item.id,
        "shape": item.shape,
        "movements": str(item.movements),
        "phases": str(len(item.phases)),
    }


def apart(places: Points, distance: float) -> Points:
    """Push places, (places, 2) float64, away from each other until none are nearer than that."""
    moved = places.copy()
    for _ in range(60):
        calm = True
        for i in range(len(moved)):
            for j in range(i):
                way = moved[i] - moved[j]
                gap = float(np.hypot(*way))
                if gap < distance - 0.01:
                    calm = False
                    aside = way / gap if gap > 1e-6 else np.array([1.0, 0.0])
                    moved[i] += aside * (distance - gap) / 2
                    moved[j] -= aside * (distance - gap) / 2
        if calm:
            break
    return moved


def _colours(diagnosis: Diagnosis) -> dict[str, str]:
    """Give colours to the shapes of several intersections, as far as there are some."""
    count: dict[str, int] = {}
    for item in diagnosis.intersections:
        count[item.shape] = count.get(item.shape, 0) + 1
    shared = sorted((shape for shape in count if count[shape] > 1), key=lambda s: -count[s])
    found = dict.fromkeys(count, ALONE)
    found.update(dict.fromkeys(shared, ANOTHER))
    found.update(zip(shared, SHAPE_COLOURS, strict=False))
    return found


@dataclass(frozen=True, slots=True)
class _Row:
    """A line of the list: a head has a colour and no number."""

    text: str
    colour: str = ""
    number: str = ""


def _listed(diagnosis: Diagnosis) -> list[_Row]:
    colours = _colours(diagnosis)
    rows = []
    whole = len(diagnosis.intersections) <= MOST_LISTED
    for shape in dict.fromkeys(item.shape for item in diagnosis.intersections):
        same = [
            (number, item)
            for number, item in enumerate(diagnosis.intersections, start=1)
            if item.shape == shape
        ]
        item = same[0][1]
        what = f"{counted(item.movements, 'movement')}, {counted(len(item.phases), 'phase')}"
        times = f" ({len(same)})" if len(same) > 1 else ""
        rows.append(_Row(f"Shape {shape}{times}: {what}", colour=colours[shape]))
        if whole:
            rows += [_Row(each.id, number=str(number)) for number, each in same]
    return rows


def _list(sheet: Sheet, rows: list[_Row], left: float) -> None:
    for index, row in enumerate(rows):
        y = 8 + index * ROW_PX
        if row.number:
            sheet.text((left + 30, y), row.number, 10.5, colour=FAINT, align="right")
            room = LIST_PX - 14 - 36
            sheet.text((left + 36, y), shortened(row.text, room, 10.5), 10.5)
    for index, row in enumerate(rows):
        y = 8 + index * ROW_PX
        if not row.number:
            sheet.dot((left + 6, y), 5, row.colour)
            sheet.text((left + 16, y), row.text, 11, bold=True)


def _foot(sheet: Sheet, diagnosis: Diagnosis, frame: _Frame) -> None:
    """Draw scale and legend below the map."""
    y = frame.size_px[1] + 12
    length_m = _round_length(0.22 * frame.size_px[0] / frame.scale)
    length_px = length_m * frame.scale
    ends = (MARGIN_PX, MARGIN_PX + length_px)
    bar = np.array([[ends[0], y - 4], [ends[0], y], [ends[1], y], [ends[1], y - 4]])
    sheet.line(bar, INK, 1.3)
    label = f"{length_m / 1000:g} km" if length_m >= 1000 else f"{length_m:g} m"
    sheet.text((MARGIN_PX + length_px + 6, y - 2), label, 10.5)
    present = {round(3.6 * link.speed_m_per_s) for link in diagnosis.case.network.links}
    entries: list[tuple[str, str, float]] = []
    least = 0.0
    for most, colour in SPEEDS_KM_PER_H:
        if any(least < speed <= most for speed in present):
            text = f"over {least:g} km/h" if most == math.inf else f"to {most:g} km/h"
            entries.append((text, colour, 3.0))
        least = most
    lanes = sorted({link.lanes for link in diagnosis.case.network.links})
    chosen = sorted({lanes[0], lanes[-1]})
    entries += [(counted(count, "lane"), "#8fa1b5", count * frame.lane_px) for count in chosen]
    x, row = float(MARGIN_PX), y + 18
    for text, colour, width in entries:
        needed = 24 + text_width(text, 10.5) + 16
        if x + needed > frame.size_px[0] + 4 and x > MARGIN_PX:
            x, row = float(MARGIN_PX), row + 15
        sheet.line(np.array([[x, row], [x + 18, row]]), colour, width)
        sheet.text((x + 23, row), text, 10.5, colour=INK)
        x += needed
    for text, node in (("boundary node", True), ("junction without signals", False)):
        if not (diagnosis.network.fringe if node else diagnosis.network.junctions):
            continue
        needed = 14 + text_width(text, 10.5) + 16
        if x + needed > frame.size_px[0] + 4 and x > MARGIN_PX:
            x, row = float(MARGIN_PX), row + 15
        sheet.dot(
            (x + 4, row),
            2.6 if node else 1.7,
            "white",
            rim=INK if node else FAINT,
            rim_width=1.1 if node else 0.6,
        )
        sheet.text((x + 12, row), text, 10.5)
        x += needed


def _round_length(length_m: float) -> float:
    """Return the largest of 1, 2, 5, 10 … that is not longer."""
    power = 10.0 ** math.floor(math.log10(max(length_m, 1e-3)))
    return next(factor * power for factor in (5, 2, 1) if factor * power <= length_m)
