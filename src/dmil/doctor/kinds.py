"""What can be found: every kind of finding, how bad it is, what it means and how to mend it."""

from __future__ import annotations

from dmil.doctor.kind import Kind

SIGNAL_KINDS = {
    "conflicting-greens": Kind(
        "error",
        "Two movements that cross or merge have the right of way (G) in one state. SUMO lets both "
        "drive. It is a warning where only lanes of one movement merge.",
        "Write g for the one that yields, or r.",
    ),
    "never-served": Kind(
        "error",
        "No stage of the signal program gives a movement green. A phase was added so that "
        "controllers can serve it, but under the own program its vehicles wait for ever.",
        "Give it green in a stage without yellow, or remove the connection.",
    ),
    "missing-yellow": Kind(
        "warning",
        "A green turns red at once. Under the own program SUMO's vehicles brake hard or drive over "
        "red; where a controller decides, the scenario's clearance stands between two phases.",
        "Put a stage with y between them.",
    ),
    "empty-stage": Kind(
        "warning",
        "A stage in which nobody goes lasts so long that it is hardly a clearance.",
        "Shorten it to the all-red time that is needed, or remove it.",
    ),
    "no-action": Kind(
        "warning",
        "No stage of the program gives green to vehicles. The phases are derived from the "
        "movements that do not cross, and there is no program to compare with.",
        "Give the program a stage with G or g.",
    ),
    "single-action": Kind(
        "warning",
        "There is only one phase, so a controller has nothing to choose.",
        "Derive phases instead (--phases derived), or leave it as it is at a pedestrian crossing.",
    ),
    "stage-order": Kind(
        "warning",
        "The stages do not follow each other in the file's order (next, or NEMA rings). As a "
        "fixed-time plan they are taken in the file's order; for rings there is none.",
        "Remove the attribute next or give a static program, if the plan is wanted.",
    ),
    "two-controllers": Kind(
        "warning",
        "A junction is under two controllers. It is taken to be the greater one's, and what the "
        "other one controls there may always go.",
        "Give it one controller (netconvert --tls.join, or netedit).",
    ),
    "no-right-of-way": Kind(
        "warning",
        "The junction has no matrix of right of way, so roads are taken to conflict with each "
        "other.",
        "Write the network anew with netconvert.",
    ),
    "long-cycle": Kind(
        "warning",
        "The own program takes more than 180 s until it begins again: drivers wait long, and a "
        "comparison with it flatters every controller. Usual are 60 to 120 s.",
        "Check the durations of its stages.",
    ),
    "clearance-beyond-interval": Kind(
        "warning",
        "Between two phases the own program clears for at least as long as the interval between "
        "two decisions; a clearance of that length would leave no green.",
        "Choose a longer --decision-interval.",
    ),
    "clearance-cut": Kind(
        "note",
        "The own program clears for longer than the scenario's timing does. Controllers then "
        "change faster than the plan may, which flatters them.",
        "Give the longer time with --clearance, and its last part as --all-red.",
    ),
    "mixed-stage": Kind(
        "note",
        "In some stages vehicles begin to go while others still have yellow. They are understood "
        "as clearance: the own program shows them, a controller cannot choose them.",
        "Nothing, unless such a stage is meant to be a phase; then give it no yellow.",
    ),
    "all-red": Kind(
        "note",
        "The own program has stages in which all is red. They are understood as clearance; under "
        "a controller the scenario's timing decides how long all is red.",
        "Give the same times with --clearance and --all-red.",
    ),
    "pedestrian-stage": Kind(
        "note",
        "A stage in which only pedestrians, bicycles or trains go. No phase shows it, so under a "
        "controller they never have green of their own.",
        "Give them green together with vehicles that they do not cross.",
    ),
    "several-programs": Kind(
        "note",
        "A controller has several programs. The last one is used, as SUMO does.",
        "Remove the others, or put the one you want last.",
    ),
    "several-junctions": Kind(
        "note",
        "One controller governs several junctions. They are one intersection with one phase.",
        "Nothing; to control them one by one, give each a controller of its own (netedit).",
    ),
    "no-vehicles": Kind(
        "note",
        "A signal controls no movement of vehicles and is left out.",
        "Nothing, if it is for pedestrians or trains.",
    ),
    "adaptive-program": Kind(
        "note",
        "The own program is actuated: in SUMO its greens adapt to the traffic, in the queue "
        "simulator they last as long as the file says. The controller 'program' is then the same "
        "as 'actuated' in SUMO, and another one in the queue simulator.",
        "Judge in SUMO (--simulator sumo).",
    ),
    "no-program": Kind(
        "note",
        "An intersection has no fixed-time program, so there is no fixed plan to compare with.",
        "Give it a program in the network's file, if that comparison is wanted.",
    ),
}
"""About signals and their programs."""

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
        "Vehicles cannot reach their goal, since no way of the network leads on. They are left "
        "out, as CityFlow does; SUMO would stop with an error.",
        "Correct the trips, or the network's connections.",
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
    "no-fixed-departure": Kind(
        "warning",
        "Vehicles have no departure in seconds, such as those that a person triggers. They are "
        "left out.",
        "Give them a departure in seconds.",
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
        "A file has programs of signals that are not part of the network. They are not used.",
        "Put them into the network with netconvert.",
    ),
    "include": Kind(
        "warning",
        "Files that another one includes are not read.",
        "Name them all as route files.",
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
    "option-not-used": Kind(
        "note",
        "The configuration has options that could change how vehicles drive and are not used.",
        "Remove them where results are compared with SUMO's own.",
    ),
    "no-road-vehicle": Kind(
        "note",
        "Bicycles, trains, pedestrians and the like are left out; only road vehicles with a motor "
        "are simulated.",
        "Nothing.",
    ),
    "person": Kind(
        "note",
        "Persons and containers are left out; only vehicles are simulated.",
        "Nothing.",
    ),
    "stops": Kind(
        "note", "Vehicles have stops, which they do not make: they drive on.", "Nothing."
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
    "device": Kind(
        "note",
        "Definitions that act on vehicles during the run, such as rerouters, are not used.",
        "Nothing; know that SUMO's own run differs.",
    ),
}
"""About vehicles, and what they ask of the signals."""

KINDS: dict[str, Kind] = {**SIGNAL_KINDS, **ROAD_KINDS, **DEMAND_KINDS}
"""Every kind of finding by its name."""


def kinds_markdown() -> str:
    """Return the documentation of all findings as Markdown (ours)."""
    lines: list[str] = []
    for title, table in (
        ("Signals and their programs", SIGNAL_KINDS),
        ("Roads", ROAD_KINDS),
        ("Vehicles, and what they ask of the signals", DEMAND_KINDS),
    ):
        lines += ["", f"### {title}", "", "| finding | severity | what it means | mend |"]
        lines.append("|-|-|-|-|")
        lines += [
            f"| `{name}` | {kind.severity} | {kind.meaning} | {kind.mend} |"
            for name, kind in table.items()
        ]
    return "\n".join(lines) + "\n"
