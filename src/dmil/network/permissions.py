"""Which vehicle classes may use which lanes: the one table that routes, queues and doctor ask."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

Classes = frozenset[str]
"""Vehicle classes. Vehicles of several (a distribution of types) go where all of them may go; those
of none (SUMO's ``ignoring``) go anywhere."""
ClassCounts = Mapping[Classes, float]
"""How many vehicles there are of which classes."""

MOTOR_CLASSES: Classes = frozenset(
    (
        *("private", "emergency", "authority", "army", "vip", "passenger", "hov", "taxi", "bus"),
        *("coach", "delivery", "truck", "trailer", "motorcycle", "moped", "evehicle"),
        *("custom1", "custom2"),
    )
)
"""SUMO's classes of road vehicles with a motor; an edge for none of them is no link."""
ALL_CLASSES: Classes = MOTOR_CLASSES | {
    *("bicycle", "pedestrian", "wheelchair", "scooter", "tram", "rail_urban", "rail"),
    *("rail_electric", "rail_fast", "subway", "cable_car", "ship", "container", "aircraft"),
    "drone",
}
"""All of SUMO's classes (SUMO docs: Vehicle Type Parameter Defaults)."""
OLD_NAMES = {
    "public_emergency": "emergency",
    "public_authority": "authority",
    "public_army": "army",
    "public_transport": "bus",
    "transport": "truck",
    "lightrail": "tram",
    "cityrail": "rail_urban",
    "rail_slow": "rail",
}
"""Names that SUMO still takes for classes, and what they are called today."""

LEAST_SHARE = 1 / 3
"""Part of the vehicles that must be allowed in a lane for it to count as a lane. Beside a lane for
all, one for a part s of the vehicles shortens the green that all need to max(1 − s, 1/2): from a
third on that is nearer to two lanes than to one."""


def permitted(allow: str | None, disallow: str | None) -> Classes:
    """Return the classes that may use a lane or connection (SUMO docs: Vehicle Permissions).

    The attributes are the file's, names with blanks between them. Without either all may, ``all``
    stands for all classes, and beside ``allow`` SUMO ignores ``disallow``.
    """
    if allow:
        return _named(allow)
    return ALL_CLASSES - _named(disallow) if disallow else ALL_CLASSES


def _named(text: str) -> Classes:
    names = {OLD_NAMES.get(name, name) for name in text.split()}
    return ALL_CLASSES if "all" in names else ALL_CLASSES & names


@dataclass(frozen=True, slots=True)
class Permissions:
    """Who may drive in which lane, and from which lane to which link (ours).

    Parameters
    ----------
    lanes
        Link id to the classes of every lane.
    ways
        Link ids (from, to) to the lanes of the first that lead to the second, and for whom.
    """

    lanes: Mapping[str, tuple[Classes, ...]]
    ways: Mapping[tuple[str, str], Mapping[int, Classes]]

    def open_to(self, link: str, classes: Classes) -> bool:
        """Tell whether vehicles may be on a link (ours)."""
        return any(classes <= lane for lane in self.lanes[link])

    def lanes_to(self, from_link: str, to_link: str, classes: Classes) -> tuple[int, ...]:
        """Return the lanes in which vehicles may go from a link to another; none: they may not."""
        ways = self.ways.get((from_link, to_link), {})
        return tuple(lane for lane, allowed in ways.items() if classes <= allowed)


def driven(permissions: Sequence[Classes], vehicles: ClassCounts | None) -> tuple[int, ...]:
    """Return which of several lanes (or connections) are worth a lane to the vehicles (ours).

    These are the ones that at least a third may use of those who may use any; where there is no
    such one, those that most may use. Where nobody of the vehicles may use any, or who drives is
    not known, all that road vehicles with a motor may use.
    """
    here = {
        classes: count
        for classes, count in (vehicles or {}).items()
        if any(classes <= allowed for allowed in permissions)
    }
    if not any(here.values()):
        return tuple(k for k, allowed in enumerate(permissions) if allowed & MOTOR_CLASSES)
    veh = [
        sum(count for classes, count in here.items() if classes <= allowed)
        for allowed in permissions
    ]
    least = min(LEAST_SHARE * sum(here.values()), max(veh))
    return tuple(k for k, count in enumerate(veh) if count >= least)


def makes_no_difference(permissions: Iterable[Classes], vehicles: ClassCounts) -> bool:
    """Tell whether every lane is for all of the vehicles, or for none with a motor (ours)."""
    everyone = frozenset[str]().union(*vehicles)
    return all(everyone <= each or not each & MOTOR_CLASSES for each in permissions)
