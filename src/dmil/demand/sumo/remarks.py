"""What was left out of SUMO's files, and why: counted by reason, not one line per vehicle."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from dmil.demand.sumo.acting import ACTING, kind_of_option
from dmil.demand.sumo.departures import Window
from dmil.errors import DemandError

TEXTS = {
    **{kind: each.text for kind, each in ACTING.items() if each.text},
    "before-begin": "depart before the beginning and are left out, as SUMO does; to have them, "
    "begin earlier",
    "after-end": "depart at or after the end and are left out; to have them, run longer",
    "unsorted": "stand after others that depart later and are left out, as SUMO does; sort the "
    "file by departure",
    "unknown-road": "go over an edge or a junction that the network does not have for vehicles and "
    "are left out; check that network and routes belong together",
    "no-way": "cannot be simulated, since the network has no route for their vehicle class, and "
    "are left out; correct the trips, or the network's connections and permissions",
    "one-road": "have a route of one road and are left out, as CityFlow does; name the road they "
    "go to",
    "ends-first": "entries end before they begin, or before second 0, and are left out, as "
    "CityFlow does; correct startTime or endTime",
    "no-road-vehicle": "are bicycles, trains and the like: SUMO drives them as traffic that others "
    "meet, the queue simulator leaves them out; measures are of road vehicles with a motor",
    "zone": "begin or end in a zone or at a coordinate and are left out; give edges, for example "
    "with duarouter",
    "stops-only": "have stops instead of an edge to go to and are left out; give the edge",
    "parameters": "have parameters (<param>), which are not used",
    "route-part": "begin or end within their route (departEdge, arrivalEdge); they drive all of it",
    "free-flow": "take the fastest route at free flow, whereas SUMO routes them by current "
    "traffic at departure",
    "signal-program": "programs of signals in route files are not used, as in SUMO; name the file "
    "as an additional one",
}
"""Kind of remark to what it says after a number and an example."""
LEFT_OUT = frozenset(
    {"unsorted", "unknown-road", "no-way", "one-road", "ends-first", "zone", "stops-only"}
)
"""Kinds of vehicles that the user thinks he has: every command tells them."""


@dataclass(frozen=True, slots=True)
class DemandRemark:
    """Something of the files that is not as in SUMO, and how often (ours).

    Parameters
    ----------
    kind
        One of the keys of `TEXTS`.
    count
        How many vehicles, or other definitions.
    example
        Id of the first.
    text
        What it is about and what to do.
    """

    kind: str
    count: int
    example: str
    text: str


def remarks_on_options(options: Iterable[str], vehicles: int) -> tuple[DemandRemark, ...]:
    """Return what there is to say of options, as ``name=value``, that give vehicles devices (ours).

    ``vehicles`` is how many there are, of which an option may give a device to some.
    """
    found = [(kind_of_option(*option.partition("=")[::2]), option) for option in options]
    return tuple(
        DemandRemark(kind, vehicles, option, TEXTS[kind]) for kind, option in found if kind
    )


def remarks_of(demand: object) -> tuple[DemandRemark, ...]:
    """Return what was left out of the files of a demand; nothing where there are none (ours).

    Of days drawn from recorded ones these are the remarks on the record.
    """
    found: tuple[DemandRemark, ...] = getattr(getattr(demand, "base", demand), "remarks", ())
    return found


class Remarks:
    """Counts remarks while files are read (ours)."""

    def __init__(self) -> None:
        self._found: dict[str, tuple[int, str, str]] = {}

    def add(self, kind: str, example: str, count: int = 1, *, place: str = "") -> None:
        """Count ``count`` more of a kind of `TEXTS`, which may be none; the first example is kept.

        The example is an id; ``place`` is an edge or a junction that it is about.
        """
        before, *first = self._found.get(kind, (0, example, place))
        if count:
            self._found[kind] = (before + count, first[0], first[1])

    def all(self) -> tuple[DemandRemark, ...]:
        """Return the remarks in the order in which their kinds are listed in `TEXTS`."""
        return tuple(
            DemandRemark(kind, count, example, f"{text} (at '{place}')" if place else text)
            for kind, text in TEXTS.items()
            for count, example, place in [self._found.get(kind, (0, "", ""))]
            if count
        )


def nobody(
    where: str, window: Window, first_s: float, definitions: int, remarks: Sequence[DemandRemark]
) -> DemandError:
    """Return the error that no vehicle is left of some definitions (ours).

    ``first_s`` is the first departure of all that can be driven, infinite if there is none; the
    remarks say why the others were left out.
    """
    begin_s, end_s = window.begin_s, window.end_s
    if first_s < math.inf:
        until = "" if end_s is None else f" and before {end_s:g} s"
        return DemandError(
            f"no vehicle departs from {begin_s:g} s on{until}",
            where=where,
            expected=f"a run that covers departures; the first is at {first_s:g} s",
            mend=f"set the begin to {math.floor(first_s)} (--begin)",
        )
    reasons = "".join(f"; {each.count} {each.text} ('{each.example}')" for each in remarks)
    return DemandError(
        f"no vehicle is left of {definitions}{reasons}" if definitions else "no vehicle",
        where=where,
        expected="vehicles, trips or flows that the network has a route for",
        mend="check that network and routes belong together"
        if definitions
        else "name the files that have them; where a program writes them, let it do so first",
    )
