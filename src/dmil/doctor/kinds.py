"""What can be found: every kind of finding, how bad it is, what it means and how to mend it."""

from __future__ import annotations

from dmil.demand.sumo.acting import ACTING
from dmil.doctor.findings import Finding, Kind, Severity
from dmil.doctor.signal_kinds import SIGNAL_KINDS

ROAD_KINDS = {
    "dead-end": Kind(
        "warning",
        "A link has no outgoing movement, at a node where others have. Vehicles can only end "
        "there.",
        "Add a connection (netedit), or remove the link.",
    ),
    "unreachable-link": Kind(
        "note",
        "A link cannot be reached from any entry of the network, or no exit can be reached from "
        "it.",
        "Correct its connections, or leave it: vehicles may start and end there.",
    ),
    "short-link": Kind(
        "note",
        "An approach is shorter than one queued vehicle. Its queue spills back over the upstream "
        "junction at once.",
        "Join the junctions at both ends (netconvert --junctions.join), or keep it in mind.",
    ),
    "left-hand-traffic": Kind(
        "note",
        "Traffic keeps to the left. This is supported: lane 0 is the leftmost, and left and right "
        "turns swap roles.",
        "Nothing; but policies trained on right-hand traffic do not apply.",
    ),
}
"""About the roads."""

DEMAND_KINDS = {
    "no-vehicle-in-time": Kind(
        "error",
        "No vehicle departs during the run: its begin is missing or wrong. The demand figures "
        "then describe the whole file.",
        "Set the begin to the first departure (--begin) and the end after the last.",
    ),
    "sumo-refuses": Kind(
        "error",
        "SUMO was to route the trips and rejected these files. Its message says why; the trips "
        "then take the fastest routes on empty roads.",
        "Correct what SUMO names: it would not simulate these files either.",
    ),
    "unknown-road": Kind(
        "error",
        "Vehicles use an edge or junction that the network does not have for vehicles. They are "
        "left out.",
        "Check that network and routes belong together.",
    ),
    "no-way": Kind(
        "error",
        "Vehicles cannot reach their destination: the network has no route for their vehicle "
        "class. They are left out, as in CityFlow; SUMO would stop with an error.",
        "Correct the trips, or the network's connections and permissions.",
    ),
    "one-road": Kind(
        "warning",
        "A CityFlow route has a single road. Its vehicles are left out, as in CityFlow.",
        "Add the destination road.",
    ),
    "ends-first": Kind(
        "warning",
        "A CityFlow entry ends before it begins, or before second 0, so no vehicle departs.",
        "Correct its startTime or endTime; -1 means no end.",
    ),
    "before-begin": Kind(
        "warning",
        "Vehicles depart before the begin and are left out, as in SUMO. A note if they are less "
        "than 5 % of all.",
        "Begin earlier (--begin) to include them.",
    ),
    "after-end": Kind(
        "warning",
        "Vehicles depart at or after the end and are left out. A note if they are less than 5 % "
        "of all.",
        "Run longer (--steps) to include them.",
    ),
    "late-start": Kind(
        "warning",
        "The first vehicle departs more than 10 minutes after the begin. Until then every metric "
        "measures an empty network.",
        "Set the begin to the first departure (--begin).",
    ),
    "endless": Kind(
        "warning",
        "Neither a flow nor the run has an end: SUMO would never stop, and no other command runs "
        "it. Figures are for the first hour.",
        "Set the length of a run (--steps), or end the flow.",
    ),
    "long-end": Kind(
        "note",
        "A run continues for more than an hour after the last departure.",
        "End it earlier (--steps).",
    ),
    "unsorted": Kind(
        "warning",
        "Vehicles are listed after others that depart later and are left out, as in SUMO.",
        "Sort the file by departure.",
    ),
    "zone": Kind(
        "warning",
        "Trips start or end in a zone or at a coordinate and are left out.",
        "Give edges, for example with duarouter.",
    ),
    "stops-only": Kind(
        "warning",
        "Trips have stops but no destination edge and are left out.",
        "Add the destination edge.",
    ),
    "signal-program": Kind(
        "warning",
        "A route file has signal programs. They are not used, as in SUMO.",
        "Load the file as an additional file, or put them into the network with netconvert.",
    ),
    "entry-beyond-capacity": Kind(
        "warning",
        "In the busiest 15 minutes more vehicles enter a link than its saturation flow. They wait "
        "outside the network.",
        "Check the demand (a flow may be in the file twice), or the number of lanes.",
    ),
    "demand-beyond-capacity": Kind(
        "warning",
        "In the busiest 15 minutes the demand at an intersection exceeds its capacity at any "
        "green split. Queues grow under every controller.",
        "Check demand, lanes and phases; also compare at a lower load.",
    ),
    "program-beyond-capacity": Kind(
        "warning",
        "In the busiest 15 minutes the network's program gives a movement too little green, "
        "though other splits would suffice. It is a weak reference.",
        "Adapt its greens to the demand before comparing with it.",
    ),
    "idle-intersection": Kind(
        "note",
        "An intersection has no traffic. Its controller learns nothing.",
        "Check whether the demand covers this area.",
    ),
    "idle-phase": Kind(
        "note",
        "No vehicle uses the movements of a phase. A learner has to find out that it is useless.",
        "Check the demand; otherwise leave it.",
    ),
    "few-pass-signals": Kind(
        "note",
        "More than half of the vehicles pass no signal. They weigh on every mean, although no "
        "controller affects them.",
        "Use metrics per intersection, or leave such trips out.",
    ),
    "give-way": Kind(
        "note",
        "Most vehicles pass an unsignalised junction where they may have to wait. The queue "
        "simulator models HCM critical gaps, first come, first served at all-way stops, and the "
        "capacity of outgoing lanes, but not time lost by braking and turning: its delays are "
        "below SUMO's, far below at roundabouts and stops; at an overloaded merge they may be "
        "above.",
        "Evaluate in SUMO (--simulator sumo).",
    ),
    "option-not-used": Kind(
        "note",
        "The configuration has unused options that could change how vehicles drive.",
        "Remove them when comparing with SUMO's own results.",
    ),
    "no-road-vehicle": Kind(
        "note",
        "Bicycles, trains etc. run in SUMO and affect others. The queue simulator leaves them "
        "out, and metrics cover motor vehicles only.",
        "Evaluate in SUMO (--simulator sumo), if they are many.",
    ),
    "parameters": Kind("note", "Vehicles have parameters that are not used.", "Nothing."),
    "route-part": Kind(
        "note",
        "Vehicles start or end within their route (departEdge, arrivalEdge). They drive all of it.",
        "Cut their routes, if the difference matters.",
    ),
    "free-flow": Kind(
        "note",
        "Trips take the fastest route without traffic, whereas SUMO routes them by current "
        "traffic when they depart. In congestion queues are then longer than in SUMO.",
        "Install SUMO and omit --routing, or give vehicles routes.",
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


def finding(
    kind: str, place: str, what: str, *, mend: str = "", severity: Severity | None = None
) -> Finding:
    """Make a finding; what is not given is that of its kind (ours)."""
    usual = KINDS[kind]
    return Finding(kind, severity or usual.severity, place, what, mend or usual.mend)


def kinds_markdown() -> str:
    """Return the documentation of all findings as Markdown (ours)."""
    lines: list[str] = []
    for title, table in (
        ("Signals and their programs", SIGNAL_KINDS),
        ("Roads", ROAD_KINDS),
        ("Vehicles, and what they ask of the signals", DEMAND_KINDS),
        ("What acts on vehicles during SUMO's run", ACTING_KINDS),
    ):
        lines += ["", f"### {title}", "", "| finding | severity | what it means | fix |"]
        lines.append("|-|-|-|-|")
        lines += [
            f"| `{name}` | {kind.severity} | {kind.meaning} | {kind.mend} |"
            for name, kind in table.items()
        ]
    return "\n".join(lines) + "\n"
