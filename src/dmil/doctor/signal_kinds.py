"""What can be found about signals and their programs."""

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
        "red; where a controller decides, the longest clearance of the plan stands between two "
        "phases, or 3 s of yellow.",
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
        "The stages do not follow each other in the file's order (next). As a "
        "fixed-time plan they are taken in the file's order.",
        "Remove the attribute next, if the plan is wanted.",
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
        "two decisions; a controller then waits for more than one decision until it sees a green.",
        "Choose a longer --decision-interval.",
    ),
    "clearance-cut": Kind(
        "warning",
        "Controllers clear for less time than the own program does, or may end a green sooner. "
        "They then change faster than the plan may, which flatters them: a comparison with the "
        "plan says nothing.",
        "Leave out --clearance, --all-red and --min-green: then controllers keep each plan's own "
        "times. The RESCO benchmark's protocol has 3 s for all; give its files by path instead.",
    ),
    "mixed-stage": Kind(
        "note",
        "In some stages vehicles begin to go while others still have yellow. They are understood "
        "as clearance: the own program shows them, a controller cannot choose them.",
        "Nothing, unless such a stage is meant to be a phase; then give it no yellow.",
    ),
    "all-red": Kind(
        "note",
        "The own program has stages in which all is red. They are understood as clearance; a "
        "controller keeps the same times.",
        "Nothing.",
    ),
    "pedestrian-stage": Kind(
        "note",
        "A stage in which only pedestrians, bicycles or trains go. No phase shows it, so under a "
        "controller they never have green of their own.",
        "Give them green together with vehicles that they do not cross.",
    ),
    "no-walk": Kind(
        "warning",
        "A crossing of pedestrians under a signal goes with no phase, so under a controller its "
        "pedestrians wait for ever.",
        "Give it green together with vehicles that do not cross it, or that give way (g).",
    ),
    "several-programs": Kind(
        "note",
        "A controller has several programs, of the network or of additional files. The one that is "
        "loaded last is used, or the one that a timetable (WAUT) names, as SUMO does.",
        "Remove the others, or load the one you want last.",
    ),
    "program-switches": Kind(
        "warning",
        "A timetable (WAUT) switches a signal's own program during the run. SUMO follows it; the "
        "queue simulator shows the program of the beginning throughout.",
        "Judge in SUMO (--simulator sumo), or within the time of one program (--begin, --steps).",
    ),
    "signal-of-sumo": Kind(
        "note",
        "A signal has no program, such as a rail crossing: SUMO works out what it shows. It is not "
        "controlled here; in the queue simulator it is a junction without signals.",
        "Nothing, if it is for trains; otherwise give it a program with netconvert.",
    ),
    "own-control": Kind(
        "warning",
        "The file's control of a signal is no plan of one stage after the other (NEMA rings), or "
        "switches it off: only SUMO can run it. As the controller 'program' it is left to SUMO "
        "there; in the queue simulator its phases in turn stand in for it, which is no reference.",
        "Judge in SUMO (--simulator sumo).",
    ),
    "several-junctions": Kind(
        "note",
        "One controller governs several junctions. They are one intersection with one phase.",
        "Nothing; to control them one by one, give each a controller of its own (netedit).",
    ),
    "shared-lanes": Kind(
        "note",
        "Movements with green in different phases share lanes. Whoever stands first in such a lane "
        "holds up all behind him while he has red, though they have green. The published rules of "
        "max-pressure and longest queue first may show that green for ever; as they are here, they "
        "and factored and lookahead see lanes that are stuck and serve who waits. Agents that "
        "learn do not see it.",
        "Nothing. Judge agents that learn, and rules with guard=false, by whether they lock.",
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
