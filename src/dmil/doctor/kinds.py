"""What can be found: every kind of finding, how bad it is, what it means and how to mend it."""

from __future__ import annotations

from dmil.demand.sumo.acting import ACTING
from dmil.doctor.kind import Kind
from dmil.doctor.signal_kinds import SIGNAL_KINDS

ROAD_KINDS = {
    "dead-end": Kind(
        "warning",
        "A link ends at a node where others go on, but no movement leads out of it. Vehicles can "
        "only end there.",
        "Add the connection (netedit), or remove the link.",
    ),
    "unreachable-link": Kind(
        "note",
        "A link cannot be reached from any road that leads into the network, or no road that leads "
        "out of the network can be reached from it.",
        "Correct its connections, or leave it: vehicles may begin and end there.",
    ),
    "short-link": Kind(
        "note",
        "A link that leads to an intersection is shorter than one queued vehicle. Its queue "
        "reaches back over the junction behind it at once.",
        "Join the junctions at both ends (netconvert --junctions.join), or know of it.",
    ),
    "left-hand-traffic": Kind(
        "note",
        "Traffic keeps to the left. All is read as it is: lane 0 is the leftmost one, and left and "
        "right turns change their roles.",
        "Nothing; but a policy that was trained on right-hand traffic does not fit.",
    ),
}
"""About the roads."""

DEMAND_KINDS = {
    "no-vehicle-in-time": Kind(
        "error",
        "No vehicle departs between the beginning and the end of a run: the begin is missing or "
        "wrong. What is said about the demand is then about the whole file.",
        "Set the begin to the first departure (--begin), and the end after the last one.",
    ),
    "sumo-refuses": Kind(
        "error",
        "SUMO was asked for the ways of the trips and refused these files. Its own message says "
        "why; the trips then drive the ways that are fastest on empty roads.",
        "Correct what SUMO names: it would refuse to simulate them as well.",
    ),
    "unknown-road": Kind(
        "error",
        "Vehicles go over an edge or a junction that the network does not have for vehicles. They "
        "are left out.",
        "Check that network and routes belong together.",
    ),
    "no-way": Kind(
        "error",
        "Vehicles cannot reach their goal, since no way of the network leads on for their vehicle "
        "class. They are left out, as CityFlow does; SUMO would stop with an error.",
        "Correct the trips, or the network's connections and permissions.",
    ),
    "one-road": Kind(
        "warning",
        "A route in CityFlow's format names a single road. Its vehicles are left out, as CityFlow "
        "does.",
        "Name the road that they go to.",
    ),
    "ends-first": Kind(
        "warning",
        "An entry in CityFlow's format ends before it begins, or before second 0, so nobody "
        "departs.",
        "Correct its startTime or endTime; for no end write -1.",
    ),
    "before-begin": Kind(
        "warning",
        "Vehicles depart before the beginning and are left out, as SUMO does. It is a note where "
        "they are less than 5 % of all.",
        "Begin earlier (--begin), if they are meant to drive.",
    ),
    "after-end": Kind(
        "warning",
        "Vehicles depart at or after the end and are left out. It is a note where they are less "
        "than 5 % of all.",
        "Run longer (--steps), if they are meant to drive.",
    ),
    "late-start": Kind(
        "warning",
        "The first vehicle departs more than 10 minutes after the beginning. Until then every "
        "number measures an empty network.",
        "Set the begin to the first departure (--begin).",
    ),
    "endless": Kind(
        "warning",
        "A flow goes on for ever, since neither it nor the run has an end: SUMO would never stop, "
        "and no other command runs it like that. What is said is about the first hour.",
        "Say how long a run lasts (--steps), or give the flow an end.",
    ),
    "long-end": Kind(
        "note",
        "A run goes on for more than an hour after the last departure.",
        "Let it end earlier (--steps).",
    ),
    "unsorted": Kind(
        "warning",
        "Vehicles stand after others that depart later and are left out, as SUMO does.",
        "Sort the file by departure.",
    ),
    "zone": Kind(
        "warning",
        "Trips begin or end in a zone or at a coordinate and are left out.",
        "Give edges, for example with duarouter.",
    ),
    "stops-only": Kind(
        "warning",
        "Trips have stops instead of an edge to go to and are left out.",
        "Give the edge that they go to.",
    ),
    "signal-program": Kind(
        "warning",
        "A route file has programs of signals. They are not used, as in SUMO.",
        "Name the file as an additional one, or put them into the network with netconvert.",
    ),
    "entry-beyond-capacity": Kind(
        "warning",
        "In the busiest 15 minutes more vehicles begin on a link than its lanes take at saturation "
        "flow. They wait outside of the network for their departure.",
        "Check the demand (a flow may stand in the file twice), or the number of lanes.",
    ),
    "demand-beyond-capacity": Kind(
        "warning",
        "In the busiest 15 minutes more vehicles come to an intersection than any division of its "
        "time can serve. Queues grow under every controller.",
        "Check demand, lanes and phases; compare at a smaller load as well.",
    ),
    "program-beyond-capacity": Kind(
        "warning",
        "In the busiest 15 minutes the own program gives a movement less green than its vehicles "
        "need, while other greens would do. It is an easy opponent.",
        "Adapt its greens to the demand before it is compared with.",
    ),
    "idle-intersection": Kind(
        "note",
        "No vehicle passes an intersection. Its controller learns nothing.",
        "Check whether the demand covers this part of the network.",
    ),
    "idle-phase": Kind(
        "note",
        "No vehicle wants to go where a phase leads. A learner has to find out that it is useless.",
        "Check the demand; else leave it as it is.",
    ),
    "few-pass-signals": Kind(
        "note",
        "More than half of the vehicles pass no signal. They make up much of every mean without "
        "anybody controlling them.",
        "Look at measures of intersections, or leave such trips out.",
    ),
    "give-way": Kind(
        "note",
        "Most vehicles pass a junction without signals where they may have to wait. The queue "
        "simulator lets them wait there by critical gaps of the HCM, first come, first served at "
        "all-way stops, and by the lanes that go on. It does not see what they lose by braking and "
        "turning: its delays are below SUMO's, at roundabouts and stops far below; where a merge "
        "is overloaded they may be above.",
        "Judge in SUMO (--simulator sumo).",
    ),
    "option-not-used": Kind(
        "note",
        "The configuration has options that could change how vehicles drive and are not used.",
        "Remove them where results are compared with SUMO's own.",
    ),
    "no-road-vehicle": Kind(
        "note",
        "Bicycles, trains and the like drive in SUMO, as traffic that others meet. The queue "
        "simulator leaves them out, and what is measured is of road vehicles with a motor.",
        "Judge in SUMO (--simulator sumo), where they are many.",
    ),
    "parameters": Kind("note", "Vehicles have parameters, which are not used.", "Nothing."),
    "route-part": Kind(
        "note",
        "Vehicles begin or end within their route (departEdge, arrivalEdge). They drive all of it.",
        "Cut their routes, if the difference matters.",
    ),
    "free-flow": Kind(
        "note",
        "Trips drive the way that is fastest without traffic, while SUMO looks for the fastest in "
        "the traffic when they depart. On congested networks queues are then longer than in SUMO.",
        "Install SUMO and leave out --routing, or give vehicles routes.",
    ),
}
"""About vehicles, and what they ask of the signals."""

ACTING_KINDS = {
    kind: Kind("warning", f"The files have {each.what}. {each.instead}", each.mend)
    for kind, each in ACTING.items()
    if each.text
}
"""About what acts on vehicles during SUMO's run."""

KINDS: dict[str, Kind] = {**SIGNAL_KINDS, **ROAD_KINDS, **DEMAND_KINDS, **ACTING_KINDS}
"""Every kind of finding by its name."""


def kinds_markdown() -> str:
    """Return the documentation of all findings as Markdown (ours)."""
    lines: list[str] = []
    for title, table in (
        ("Signals and their programs", SIGNAL_KINDS),
        ("Roads", ROAD_KINDS),
        ("Vehicles, and what they ask of the signals", DEMAND_KINDS),
        ("What acts on vehicles during SUMO's run", ACTING_KINDS),
    ):
        lines += ["", f"### {title}", "", "| finding | severity | what it means | mend |"]
        lines.append("|-|-|-|-|")
        lines += [
            f"| `{name}` | {kind.severity} | {kind.meaning} | {kind.mend} |"
            for name, kind in table.items()
        ]
    return "\n".join(lines) + "\n"
