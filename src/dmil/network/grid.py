"""The paper's grids: n×m four-way intersections with a fringe node at every boundary approach."""

from __future__ import annotations

import math

from dmil.errors import NetworkError
from dmil.network.model import Intersection, Link, Movement, RoadNetwork, Turn

SIDES = ("E", "N", "W", "S")
LINK_SPEED_M_PER_S = 10.0
LINK_TIME_S = 5.0
ENTRY_LINK_TIME_S = 0.0
LANES = 3

_TURN_TO_SIDE: tuple[tuple[Turn, int], ...] = (("right", 1), ("straight", 2), ("left", 3))

# Local movement index j = 3*side + lane, sides E, N, W, S, lanes right, forward, left.
PAPER_PHASES: tuple[frozenset[int], ...] = tuple(
    frozenset(phase)
    for phase in ((1, 7), (2, 8), (4, 10), (5, 11), (1, 2), (4, 5), (7, 8), (10, 11))
)
PAPER_PHASE_NAMES = ("E/W F", "E/W L", "N/S F", "N/S L", "E F+L", "N F+L", "W F+L", "S F+L")
PAPER_UNSIGNALLED = frozenset({0, 3, 6, 9})


def grid(
    rows: int,
    columns: int,
    *,
    link_time_s: float = LINK_TIME_S,
    entry_link_time_s: float = ENTRY_LINK_TIME_S,
) -> RoadNetwork:
    """Build a grid of the paper's four-way intersections (paper, §III and §VI).

    Intersections are named ``"row,column"``, row 0 in the North and column 0 in the West. Fringe
    nodes carry their side of the network and the row or column: ``"E2"``, ``"N0"``. On all links
    vehicles drive 10 m/s, so the times make their lengths.

    Parameters
    ----------
    rows, columns
        Number of intersections from North to South and from West to East, each at least 1.
    link_time_s
        Seconds on a link between intersections.
    entry_link_time_s
        Seconds on an entry link, and on an exit link.

    Raises
    ------
    NetworkError
        If a number of intersections is not positive and whole, or a time is negative or not finite.

    Notes
    -----
    The paper does not state how long a link takes; 5 s reproduces its magnitudes.
    """
    for axis, value in (("rows", rows), ("columns", columns)):
        if isinstance(value, bool) or not isinstance(value, int) or value < 1:
            raise NetworkError(
                f"{axis} is {value!r}",
                where="grid",
                expected="a whole number, at least 1",
                mend="write for example grid(5, 5)",
            )
    for name, time_s in (("link_time_s", link_time_s), ("entry_link_time_s", entry_link_time_s)):
        if not (math.isfinite(time_s) and time_s >= 0):
            raise NetworkError(
                f"{name} is {time_s}", where="grid", expected="a number of seconds, 0 or more"
            )
    cells = [(row, column) for row in range(rows) for column in range(columns)]
    links: dict[str, Link] = {}
    for row, column in cells:
        here = f"{row},{column}"
        for side in range(4):
            there = _neighbour(row, column, side, rows, columns)
            length_m = (link_time_s if "," in there else entry_link_time_s) * LINK_SPEED_M_PER_S
            for start, end in ((there, here), (here, there)):
                link = Link(f"{start}>{end}", start, end, length_m, LINK_SPEED_M_PER_S, LANES)
                links.setdefault(link.id, link)
    fringe = (
        *(f"E{row}" for row in range(rows)),
        *(f"N{column}" for column in range(columns)),
        *(f"W{row}" for row in range(rows)),
        *(f"S{column}" for column in range(columns)),
    )
    return RoadNetwork(
        name=f"grid:{rows}x{columns}",
        links=tuple(links.values()),
        intersections=tuple(_intersection(row, column, rows, columns) for row, column in cells),
        fringe=fringe,
        position_m=_positions(rows, columns, (link_time_s or LINK_TIME_S) * LINK_SPEED_M_PER_S),
    )


def _neighbour(row: int, column: int, side: int, rows: int, columns: int) -> str:
    """Return the node on a side (0 E, 1 N, 2 W, 3 S) of an intersection."""
    step_row, step_column = ((0, 1), (-1, 0), (0, -1), (1, 0))[side]
    next_row, next_column = row + step_row, column + step_column
    if 0 <= next_row < rows and 0 <= next_column < columns:
        return f"{next_row},{next_column}"
    return f"{SIDES[side]}{row if step_row == 0 else column}"


def _intersection(row: int, column: int, rows: int, columns: int) -> Intersection:
    here = f"{row},{column}"
    around = [_neighbour(row, column, side, rows, columns) for side in range(4)]
    movements = tuple(
        Movement(
            f"{around[side]}>{here}", f"{here}>{around[(side + step) % 4]}", turn, side, (lane,)
        )
        for side in range(4)
        for lane, (turn, step) in enumerate(_TURN_TO_SIDE)
    )
    return Intersection(
        here, movements, PAPER_PHASES, PAPER_UNSIGNALLED, phase_names=PAPER_PHASE_NAMES
    )


def _positions(rows: int, columns: int, apart_m: float) -> dict[str, tuple[float, float]]:
    """Place nodes a link's length apart; fringe nodes too, so that drawings show them."""
    position: dict[str, tuple[float, float]] = {}
    east, north = columns * apart_m, rows * apart_m
    for row in range(rows):
        y = (rows - 1 - row) * apart_m
        position[f"E{row}"] = (east, y)
        position[f"W{row}"] = (-apart_m, y)
        for column in range(columns):
            position[f"{row},{column}"] = (column * apart_m, y)
    for column in range(columns):
        position[f"N{column}"] = (column * apart_m, north)
        position[f"S{column}"] = (column * apart_m, -apart_m)
    return position
