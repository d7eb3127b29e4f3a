"""What can be found about signals and their programs."""

from __future__ import annotations

from dmil.doctor.findings import Kind

SIGNAL_KINDS = {
    "conflicting-greens": Kind(
        "error",
        "Two crossing or merging movements both have priority (G) in one state. SUMO lets both "
        "go. A warning where only lanes of one movement merge.",
        "Write g for the yielding movement, or r.",
    ),
    "never-served": Kind(
        "error",
        "No stage of the signal program gives a movement green. A phase was added so that "
        "controllers can serve it, but under the network's program its vehicles wait forever.",
        "Give it green in a stage without yellow, or delete the connection.",
    ),
    "missing-yellow": Kind(
        "warning",
        "A green turns red without yellow. Under the network's program SUMO's vehicles brake hard "
        "or run the red; under a controller, phases are separated by the plan's longest "
        "clearance, or 3 s of yellow.",
        "Insert a stage with y.",
    ),
    "empty-stage": Kind(
        "warning",
        "A stage without any green is too long for a clearance.",
        "Shorten it to the necessary all-red time, or remove it.",
    ),
    "no-action": Kind(
        "warning",
        "No stage of the program gives green to vehicles. The phases are derived from movements "
        "that do not conflict, and there is no program to compare with.",
        "Give the program a stage with G or g.",
    ),
    "single-action": Kind(
        "warning",
        "There is only one phase, so a controller has nothing to choose.",
        "Derive phases instead (--phases derived); at a pedestrian crossing leave it.",
    ),
    "stage-order": Kind(
        "warning",
        "The stages do not run in file order (next). As a fixed-time plan they do here.",
        "Remove the attribute next, if you need the plan.",
    ),
    "two-controllers": Kind(
        "warning",
        "A junction has two signal controllers. It is assigned to the larger one; connections of "
        "the other one are always open there.",
        "Give it one controller (netconvert --tls.join, or netedit).",
    ),
    "no-right-of-way": Kind(
        "warning",
        "The junction has no right-of-way matrix, so all roads are taken to conflict.",
        "Rebuild the network with netconvert.",
    ),
    "long-cycle": Kind(
        "warning",
        "The cycle of the network's program exceeds 180 s: drivers wait long, and a comparison "
        "with it flatters every controller. 60 to 120 s are usual.",
        "Check the durations of its stages.",
    ),
    "clearance-beyond-interval": Kind(
        "warning",
        "The clearance of the network's program is at least as long as the decision interval; a "
        "controller then sees a green only after more than one decision.",
        "Choose a longer --decision-interval.",
    ),
    "clearance-cut": Kind(
        "warning",
        "Controllers have shorter clearances or minimum greens than the network's program, so "
        "they may change phases faster: the comparison with the plan is unfair.",
        "Omit --clearance, --all-red and --min-green: then controllers use each plan's times. The "
        "RESCO protocol has 3 s for all; give its files by path instead.",
    ),
    "mixed-stage": Kind(
        "note",
        "Some stages have green and yellow at once. They are treated as clearance: the network's "
        "program shows them, a controller cannot choose them.",
        "Nothing, unless such a stage is meant to be a phase; then remove its yellow.",
    ),
    "all-red": Kind(
        "note",
        "The network's program has all-red stages. They are treated as clearance; a controller "
        "uses the same times.",
        "Nothing.",
    ),
    "pedestrian-stage": Kind(
        "note",
        "A stage for pedestrians, bicycles or trains only. No phase contains it, so under a "
        "controller they get no exclusive green.",
        "Give them green together with vehicles that do not conflict.",
    ),
    "no-walk": Kind(
        "warning",
        "No phase gives green to a signalled pedestrian crossing, so under a controller its "
        "pedestrians wait forever.",
        "Give it green together with vehicles that do not cross it, or that yield (g).",
    ),
    "several-programs": Kind(
        "note",
        "A signal has several programs, from the network or additional files. As in SUMO, the "
        "last one loaded is used, or the one that a schedule (WAUT) names.",
        "Remove the others, or load yours last.",
    ),
    "program-switches": Kind(
        "warning",
        "A schedule (WAUT) switches a signal's program during the run. SUMO follows it; the queue "
        "simulator keeps the initial program.",
        "Evaluate in SUMO (--simulator sumo), or within the period of one program (--begin, "
        "--steps).",
    ),
    "signal-of-sumo": Kind(
        "note",
        "A signal has no program, such as a rail crossing: SUMO decides what it shows. It is not "
        "controlled here; in the queue simulator it is an unsignalised junction.",
        "Nothing, if it is for trains; otherwise add a program with netconvert.",
    ),
    "own-control": Kind(
        "warning",
        "A signal's control is not a sequence of stages (NEMA rings), or switches it off: only "
        "SUMO can run it. The controller 'program' leaves it to SUMO there; the queue simulator "
        "cycles through its phases instead, which is no valid reference.",
        "Evaluate in SUMO (--simulator sumo).",
    ),
    "several-junctions": Kind(
        "note",
        "One signal controller serves several junctions. They form one intersection with one "
        "phase at a time.",
        "Nothing; to control them separately, give each its own controller (netedit).",
    ),
    "shared-lanes": Kind(
        "note",
        "Movements with green in different phases share lanes. A vehicle with red at the head of "
        "such a lane blocks those behind it, though they have green. Max-pressure and "
        "longest-queue-first as published may show that green forever, and so may learners; here, "
        "all that would detect blocked lanes and serve the blocking vehicle (guard).",
        "Nothing. With guard=false, check whether they gridlock.",
    ),
    "locking-lanes": Kind(
        "note",
        "No phase gives green to all movements of a lane together. With guard=false max-pressure "
        "and longest-queue-first (the published rules), factored, lookahead and combined lock "
        "there as soon as a vehicle with red stands first and the counts speak for those behind "
        "it; so may learners. Plans, gap-out and sotl serve everybody in turn.",
        "Leave guard=true, the default. A rule with guard=false is no valid reference here.",
    ),
    "clearance-kind": Kind(
        "warning",
        "The kind of clearance that is given is not that of the plan: with kept, movements with "
        "green before and after a change keep it, with all-stop they stop like all others. A "
        "controller with kept loses less time than a plan that stops everybody, one with all-stop "
        "more than a plan that does not: the comparison is unfair.",
        "Omit --clearance-kind: then controllers use each plan's. The RESCO protocol has kept for "
        "all; give its files by path instead.",
    ),
    "no-vehicles": Kind(
        "note",
        "A signal controls no vehicle movement and is left out.",
        "Nothing, if it is for pedestrians or trains.",
    ),
    "adaptive-program": Kind(
        "note",
        "The network's program is actuated: in SUMO its greens adapt to traffic, in the queue "
        "simulator they last as long as the file says. In SUMO the controller 'program' is then "
        "the same as 'actuated'.",
        "Evaluate in SUMO (--simulator sumo).",
    ),
    "no-program": Kind(
        "note",
        "An intersection has no fixed-time program, so there is no fixed plan to compare with.",
        "Add a program to the network file, if you want that comparison.",
    ),
}
"""About signals and their programs."""
