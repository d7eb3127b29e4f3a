"""Pictures of a network: roads, waiting vehicles and the phases shown."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from dmil.errors import MissingExtraError
from dmil.interop.streets import Streets, Strip
from dmil.network import RoadNetwork
from dmil.network.lines import Points
from dmil.simulation import Observation

FINE = 3
"""Everything is drawn so many times larger and then reduced, which makes smooth edges."""
HEADER_PX = 56
NARROWEST_LABEL_PX = 7

PAPER, SIDE_ROAD, ROAD, NODE = "#fbfaf8", "#eeece7", "#dfddd7", "#d3d0c9"
INK, FAINT = "#2b2b2b", "#77736b"
# Okabe and Ito's palette, told apart by colour-blind readers.
RED, GREEN, FREE, COMING = "#d55e00", "#009e73", "#56b4e9", "#a39f96"
LEGEND = ((RED, "red"), (GREEN, "green"), (FREE, "no signal"), (COMING, "approaching"))


class Picture:
    """Draws observations of a network, one picture after the other.

    A row of boxes in front of a stop line is a queue, one box a vehicle, coloured by what the
    signal shows; grey boxes behind it are vehicles that reach the queue within one decision
    interval. Arrows are the movements that have green. Where a queue is longer than its link, a
    number says how many vehicles wait.

    Parameters
    ----------
    network
        The roads; links are drawn straight from node to node, wider than they are.

    Raises
    ------
    MissingExtraError
        If Pillow is not installed.
    """

    def __init__(self, network: RoadNetwork) -> None:
        try:
            from PIL import Image, ImageDraw, ImageFont
        except ImportError:
            raise MissingExtraError("zoo") from None
        self._brush_of, self._font_of = ImageDraw.Draw, ImageFont.load_default
        self._intersections = network.intersections
        self._streets = Streets(network, HEADER_PX)
        width, height = self._streets.size_px
        self._empty = Image.new("RGB", (width * FINE, height * FINE), PAPER)
        self._lay_roads(self._brush_of(self._empty))

    def draw(self, observation: Observation, title: str) -> npt.NDArray[np.uint8]:
        """Draw one moment: (height, width, 3) uint8.

        Above it stand a title, the time and the number of vehicles that wait.
        """
        picture = self._empty.copy()
        brush = self._brush_of(picture)
        for i, item in enumerate(self._intersections):
            shown = int(observation.phase[i])
            green = item.phases[shown] if shown >= 0 else frozenset()
            for j, strip in enumerate(self._streets.strips[i]):
                if strip is None:
                    continue
                colour = FREE if j in item.unsignalled else GREEN if j in green else RED
                queue = int(observation.queue_veh[i, j])
                self._queue(brush, strip, queue, int(observation.approaching_veh[i, j]), colour)
                if strip.way is not None and colour != RED:
                    self._arrow(brush, strip.way, colour)
        waiting = int(observation.queue_veh.sum())
        self._text(brush, (16, 10), title, 16, INK)
        self._text(brush, (16, 32), f"{observation.time_s} s,  {waiting} waiting", 12, FAINT)
        return np.array(picture.reduce(FINE), np.uint8)

    def _lay_roads(self, brush: Any) -> None:
        streets = self._streets
        # What signals govern lies above what they do not.
        for road in sorted(streets.roads, key=lambda road: road.signalled):
            _fill(brush, road.corners, ROAD if road.signalled else SIDE_ROAD)
        for node in streets.nodes:
            _fill(brush, node.corners, NODE if node.signalled else SIDE_ROAD)
        width = round(FINE * max(0.8, streets.lane_px / 8))
        for road in streets.roads:
            if road.signalled:
                line = [tuple(point * FINE) for point in road.corners[:2]]
                brush.line(line, fill=PAPER, width=width)
        self._lay_legend(brush)

    def _lay_legend(self, brush: Any) -> None:
        """Put the meaning of the colours at the right above the roads."""
        x = self._streets.size_px[0] - 16.0
        font = self._font_of(size=11 * FINE)
        for colour, meaning in reversed(LEGEND):
            x -= font.getlength(meaning) / FINE
            self._text(brush, (x, 32), meaning, 11, FAINT)
            box = [FINE * v for v in (x - 14, 34, x - 5, 43)]
            brush.rounded_rectangle(box, radius=2 * FINE, fill=colour)
            x -= 26

    def _queue(self, brush: Any, strip: Strip, queue: int, coming: int, colour: str) -> None:
        length = self._streets.vehicle_px
        room = max(1, int(strip.room_px / length))
        for k in range(min(queue + coming, room)):
            near = strip.stop + strip.back * (k + 0.1) * length
            far = strip.stop + strip.back * (k + 0.9) * length
            across = np.array([-strip.back[1], strip.back[0]]) * strip.width_px * 0.36
            corners = np.array([near - across, near + across, far + across, far - across])
            _fill(brush, corners, colour if k < queue else COMING)
        if queue > room and strip.width_px >= NARROWEST_LABEL_PX:
            end = strip.stop + strip.back * (strip.room_px - 6)
            self._text(brush, (end[0], end[1]), str(queue), 10, INK, anchor="mm")

    def _arrow(self, brush: Any, way: Points, colour: str) -> None:
        thin = 0.12 if colour == FREE else 0.2
        width = max(1.0, self._streets.lane_px * thin)
        along = way[-1] - way[-2]
        along /= max(float(np.hypot(*along)), 1e-9)
        across = np.array([-along[1], along[0]])
        base = way[-1] - along * 3.2 * width
        brush.line(
            [tuple(point * FINE) for point in (*way[:-2], base)],
            fill=colour,
            width=round(width * FINE),
            joint="curve",
        )
        _fill(
            brush,
            np.array([base + across * 1.9 * width, way[-1], base - across * 1.9 * width]),
            colour,
        )

    def _text(
        self,
        brush: Any,
        place: tuple[float, float],
        text: str,
        size_px: int,
        colour: str,
        anchor: str = "la",
    ) -> None:
        x, y = place
        font = self._font_of(size=size_px * FINE)
        # Letters on vehicles and roads stand out by a rim.
        rim = FINE if anchor == "mm" else 0
        brush.text(
            (x * FINE, y * FINE),
            text,
            fill=colour,
            font=font,
            anchor=anchor,
            stroke_width=rim,
            stroke_fill=PAPER,
        )


def _fill(brush: Any, corners: Points, colour: str) -> None:
    brush.polygon([tuple(corner * FINE) for corner in corners], fill=colour)
