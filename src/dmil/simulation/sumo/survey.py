"""What SUMO's own detectors note in a run: crossings of stop lines, greens, times on links."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple
from xml.sax.saxutils import quoteattr

import numpy as np
import numpy.typing as npt

from dmil.demand import Vehicles
from dmil.network import RoadNetwork
from dmil.simulation.sumo.accounts import elements
from dmil.simulation.sumo.files import RunFiles

FloatArray = npt.NDArray[np.float64]
LongArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

STOP_LINE_M = -0.1
"""Place of the detectors on a lane, counted from its end."""
GREEN = frozenset("Gg")


class Survey(NamedTuple):
    """A run as SUMO's outputs tell it. A place is an index into the vehicles' route links.

    Attributes
    ----------
    entered_s: (vehicles,) float64
        When a vehicle entered the network; NaN if it did not.
    left_s: (places,) float64
        When it left the place's link for the junction behind; NaN if it did not.
    crossed_s: (places,) float64
        When its front crossed the signalled stop line of the place's link; NaN if it did not, or
        there is none.
    lane: (places,) int64
        The lane on which it crossed, network-wide; −1 if it did not.
    green: (seconds, intersections, movements) bool
        What had green in every second.
    """

    entered_s: FloatArray
    left_s: FloatArray
    crossed_s: FloatArray
    lane: LongArray
    green: BoolArray


@dataclass(slots=True)
class SurveyFiles:
    """Asks SUMO for the outputs of a run, into a folder, and reads them afterwards (ours)."""

    network: RoadNetwork
    folder: Path
    _files: RunFiles | None = None

    def options(self, files: RunFiles) -> list[str]:
        """Write the detectors down; return the options of ``sumo`` that let it write (ours)."""
        self._files = files
        additional = self.folder / "detectors.add.xml"
        name = quoteattr(str(self.folder / "crossings.xml"))
        states = quoteattr(str(self.folder / "states.xml"))
        with additional.open("w", encoding="utf-8") as text:
            text.write(f'<additional>\n<timedEvent type="SaveTLSStates" dest={states}/>\n')
            for number, (link, lane) in enumerate(self._stop_lines()):
                road = quoteattr(f"{files.edges[link]}_{lane}")
                text.write(
                    f'<instantInductionLoop id="{number}" lane={road} pos="{STOP_LINE_M}"'
                    f' friendlyPos="true" file={name}/>\n'
                )
            text.write("</additional>\n")
        return [
            *("--additional-files", str(additional)),
            *("--vehroute-output", str(self.folder / "routes.xml")),
            "--vehroute-output.exit-times",
            "--vehroute-output.write-unfinished",
        ]

    def read(self, vehicles: Vehicles, seconds: int) -> Survey:
        """Return what SUMO has written about a run of some seconds, when it is over (ours)."""
        assert self._files is not None
        begin_s = self._files.begin_s
        entered_s = np.full(len(vehicles), np.nan)
        left_s = np.full(vehicles.route_links.size, np.nan)
        offset, links = vehicles.route_offset, vehicles.route_links
        names = [quoteattr(edge)[1:-1].encode() for edge in self._files.edges]
        vehicle, measured = -1, False
        for kind, values in elements((self.folder / "routes.xml").read_bytes(), b"vehicle|route"):
            if kind == b"vehicle":
                measured = values[b"id"].isdigit()
                if not measured:
                    continue
                vehicle = int(values[b"id"])
                entered_s[vehicle] = float(values[b"depart"]) - begin_s
            elif measured and b"exitTimes" in values:
                first, last = offset[vehicle], offset[vehicle + 1]
                if values[b"edges"].split() != [names[link] for link in links[first:last]]:
                    continue  # SUMO has sent it elsewhere
                times = np.array(values[b"exitTimes"].split(), np.float64)
                left_s[first : first + times.size] = np.where(times < 0, np.nan, times - begin_s)
        crossed_s, lane = self._crossings(vehicles, begin_s)
        return Survey(entered_s, left_s, crossed_s, lane, self._green(seconds, begin_s))

    def _stop_lines(self) -> list[tuple[int, int]]:
        """Return link and lane of every signalled stop line."""
        found = {
            (self.network.link_index[movement.from_link], lane)
            for item in self.network.intersections
            for movement in item.movements
            for lane in self.network.lanes_to(movement)
        }
        return sorted(found)

    def _crossings(self, vehicles: Vehicles, begin_s: int) -> tuple[FloatArray, LongArray]:
        link_of = [link for link, _ in self._stop_lines()]
        offset, links = vehicles.route_offset, vehicles.route_links
        crossed_s, lane = np.full(links.size, np.nan), np.full(links.size, -1, np.int64)
        for _, values in elements((self.folder / "crossings.xml").read_bytes(), b"instantOut"):
            if values[b"state"] != b"enter" or not values[b"vehID"].isdigit():
                continue
            vehicle, number = int(values[b"vehID"]), int(values[b"id"])
            first, last = offset[vehicle], offset[vehicle + 1]
            for place in first + np.flatnonzero(links[first:last] == link_of[number]):
                if lane[place] < 0:  # who passes a link twice crosses its line twice, in order
                    crossed_s[place] = float(values[b"time"]) - begin_s
                    lane[place] = number
                    break
        return crossed_s, lane

    def _green(self, seconds: int, begin_s: int) -> BoolArray:
        assert self._files is not None
        signals = self._files.signals
        index = {item.id.encode(): i for i, item in enumerate(signals)}
        width = max(len(item.movements) for item in self.network.intersections)
        green = np.zeros((seconds, len(signals), width), np.bool_)
        known: dict[tuple[int, bytes], BoolArray] = {}
        for _, values in elements((self.folder / "states.xml").read_bytes(), b"tlsState"):
            # SUMO notes at the end of a step what was shown in it.
            second, i = int(float(values[b"time"])) - begin_s - 1, index.get(values[b"id"])
            if i is None or not 0 <= second < seconds:
                continue
            state = values[b"state"]
            if (i, state) not in known:
                known[i, state] = _served(state.decode(), signals[i].links, width)
            green[second, i] = known[i, state]
        return green


def _served(state: str, links: Sequence[Sequence[int]], width: int) -> BoolArray:
    served = np.zeros(width, np.bool_)
    for j, places in enumerate(links):
        served[j] = any(state[place] in GREEN for place in places)
    return served
