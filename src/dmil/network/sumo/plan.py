"""Actions of one controller, from its program or derived, and the crossings that go with them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from dmil.network.model import Walk
from dmil.network.program import Program, Stage, longest_clearance_s
from dmil.network.sumo.cliques import conflict_free_phases
from dmil.network.sumo.records import CrossingRecord, Logic, NetFile
from dmil.network.sumo.signal_programs import OFF
from dmil.network.sumo.ways import Pairs, SumoMovements, letters_of

NEMA, STATIC = "NEMA", "static"
NO_SEQUENCE = (NEMA, OFF)
"""Types of programs that are no plan of one stage after the other: parallel rings, all off."""

Links = tuple[tuple[int, ...], ...]
"""For every movement its indices into the controller's state strings."""


@dataclass(frozen=True, slots=True)
class SignalPlan:
    """The phases of one intersection, and its own program in their terms (ours).

    Parameters
    ----------
    phases, states
        Movements of every phase, and its state string.
    unsignalled
        Movements that may always go.
    program
        The file's program, None where it is no sequence of stages or has no green.
    own_control
        SUMO's type of a control that is no sequence of stages, else empty.
    clearance_s
        Longest run of stages between two actions.
    added
        Movements that the program never serves; phases were added for them.
    derived
        Whether the phases are derived.
    """

    phases: tuple[frozenset[int], ...]
    states: tuple[str, ...]
    unsignalled: frozenset[int]
    program: Program | None
    clearance_s: float
    own_control: str = ""
    added: frozenset[int] = frozenset()
    derived: bool = False


def going(state: str, links: Links, letters: str) -> frozenset[int]:
    """Return the movements one of whose links shows one of the letters, such as ``"Gg"`` (ours)."""
    return frozenset(j for j, own in enumerate(links) if any(state[k] in letters for k in own))


def is_action(state: str, links: Links) -> bool:
    """Whether a stage gives green to vehicles and lets none of them clear (ours)."""
    return bool(going(state, links, "Gg")) and not going(state, links, "yu")


def plan_of(
    logic: Logic, ways: SumoMovements, links: Links, conflicts: Pairs, *, derive: bool
) -> SignalPlan:
    """Find the actions of a controller (ours).

    An action is a stage in which vehicles have green and none has yellow; stages that serve the
    same movements are one. A movement that may go in all of several actions, be it after a stop
    (right turn on red), is unsignalled, unless an action would then be empty; and so is one with a
    lane that no signal controls. The links are of the lanes that vehicles use. With ``derive`` the
    program's stages are left aside.
    """
    every = letters_of(ways.connections, logic.id)
    open_ = frozenset(
        j for j, group in enumerate(ways.driven) if any(way.signal != logic.id for way in group)
    )
    states = [stage.state for stage in logic.stages]
    actions = [s for s in states if is_action(s, links) and going(s, links, "Gg") - open_]
    green = frozenset().union(*(going(state, links, "Gg") for state in actions))

    def served(state: str) -> frozenset[int]:
        # Where the letter for a turn on red is the best that a movement ever gets, it is its green.
        return going(state, links, "Gg") | (going(state, links, "soO") - green)

    if derive or not actions or logic.kind == NEMA:
        phases, strings, unsignalled = _derived(logic, ways, every, conflicts, open_)
        added: frozenset[int] = frozenset()
        derived = True
    else:
        always = frozenset.intersection(*(going(state, links, "GgsoO") for state in actions))
        different = {served(state) - open_ for state in actions}
        # A left turn that yields in one stage and has the second to itself needs its signal: it
        # may be unsignalled only where every action serves somebody else too.
        free = len(different) > 1 and all(phase - always for phase in different)
        unsignalled = open_ | always if free else open_
        first: dict[frozenset[int], str] = {}
        for state in actions:
            shown = first.setdefault(served(state) - unsignalled, state)
            if _with_more_others(state, shown, links):
                first[served(state) - unsignalled] = state
        wanted = frozenset(range(len(links))) - unsignalled
        added = wanted - frozenset().union(*first)
        for phase in conflict_free_phases(ways.movements, conflicts, wanted, need=added):
            shown = actions[0].replace("G", "g")
            first[phase] = _state(phase, every, shown, keep=unsignalled)
        phases, strings, derived = tuple(first), tuple(first.values()), False
    stages = tuple(
        Stage(
            stage.duration_s,
            served(stage.state) - unsignalled,
            stage.state not in actions,
            yellow=going(stage.state, links, "y"),
            others=others_go(stage.state, links),
            min_s=stage.min_s,
            max_s=stage.max_s,
        )
        for stage in logic.stages
        if stage.duration_s > 0
    )
    usable = logic.kind not in NO_SEQUENCE and any(stage.green for stage in stages)
    return SignalPlan(
        phases,
        strings,
        unsignalled,
        Program(stages, logic.offset_s, logic.kind != STATIC) if usable else None,
        _clearance_s(logic, links) if len(phases) > 1 else 0.0,
        logic.kind if logic.kind in NO_SEQUENCE else "",
        added,
        derived,
    )


def _with_more_others(state: str, shown: str, links: Links) -> bool:
    """Whether two states are the same for vehicles, and more pedestrians go in the first."""
    mine = {k for own in links for k in own}
    alike = all(state[k] == shown[k] for k in mine)
    return alike and sum(map(state.count, "Gg")) > sum(map(shown.count, "Gg"))


def _derived(
    logic: Logic, ways: SumoMovements, links: Links, conflicts: Pairs, open_: frozenset[int]
) -> tuple[tuple[frozenset[int], ...], tuple[str, ...], frozenset[int]]:
    wanted = frozenset(range(len(links))) - open_
    phases = conflict_free_phases(ways.movements, conflicts, wanted)
    unsignalled = open_
    if len(phases) > 1:
        # Who is in all of them crosses nobody.
        always = frozenset.intersection(*phases)
        phases = tuple(phase - always for phase in phases)
        unsignalled |= always
    size = max(len(stage.state) for stage in logic.stages)
    shown = _state(unsignalled - open_, links, "g" * size, keep=open_)
    return (
        phases,
        tuple(_state(phase, links, shown, keep=unsignalled) for phase in phases),
        unsignalled,
    )


def _state(phase: frozenset[int], links: Links, shown: str, *, keep: frozenset[int]) -> str:
    """Return a state string: green for the phase, the letters shown for ``keep``, else red."""
    letters = ["r"] * len(shown)
    for j in sorted(keep):
        for k in links[j]:
            letters[k] = shown[k]
    for j in sorted(phase):
        for k in links[j]:
            letters[k] = "G"
    return "".join(letters)


def _clearance_s(logic: Logic, links: Links) -> float:
    """Return the longest time between two actions; a green for pedestrians is no clearance."""
    actions = [is_action(stage.state, links) for stage in logic.stages]
    stages = [
        (stage.duration_s, not (action or others_go(stage.state, links)))
        for stage, action in zip(logic.stages, actions, strict=True)
    ]
    return longest_clearance_s(stages) if any(actions) else 0.0


def others_go(state: str, links: Sequence[tuple[int, ...]]) -> bool:
    """Whether nobody but pedestrians or others who are no vehicles may go (ours)."""
    mine = {k for own in links for k in own}
    vehicles = any(state[k] in "Ggyu" for k in mine)
    return not vehicles and any(letter in "Gg" for k, letter in enumerate(state) if k not in mine)


WALKING_M_PER_S = 1.2
LEAST_WALK_S = 5
"""Where a file says nothing: the shortest green of pedestrians."""
_RIGHTS = "gG".find
"""What a letter allows: who turns over a crossing with g gives way to it, with G does not."""


def crossings_of(signal: str, file: NetFile) -> tuple[CrossingRecord, ...]:
    """Return the crossings that a controller's letters stand for, in their order (ours)."""
    mine = (each for each in file.crossings if each.signal == signal)
    return tuple(sorted(mine, key=lambda each: each.letter))


def walk_of(
    crossing: CrossingRecord, logic: Logic, plan: SignalPlan, links: Links, file: NetFile
) -> Walk:
    """Find out when pedestrians go, and how long it takes them to clear a crossing (ours).

    Clearing takes as long as the plan leaves between their green and that of vehicles that cross
    them; where other vehicles go in between, no longer than the walk does at 1.2 m/s, and that is
    also what counts where the plan does not say. Who crosses whom is in the file.
    """
    foes = file.foes.get((crossing.junction, crossing.row), frozenset())
    letters = {
        way.letter
        for way in file.connections
        if way.signal == logic.id and way.junction == crossing.junction and way.row in foes
    }
    needed_s = math.ceil(crossing.length_m / WALKING_M_PER_S)
    greens, clearing = [], []
    for green_s, to_next_s, to_foe_s in _walks(crossing.letter, letters, logic, links):
        greens.append(green_s)
        if to_foe_s is not None:
            enough_s = max(to_next_s or 0.0, needed_s)
            clearing.append(to_foe_s if to_foe_s == to_next_s else min(to_foe_s, enough_s))
    return Walk(
        phases=frozenset(
            p for p, state in enumerate(plan.states) if state[crossing.letter] in "Gg"
        ),
        least_s=math.ceil(min([LEAST_WALK_S, *greens])),
        clear_s=math.ceil(max(clearing)) if clearing else needed_s,
    )


def _walks(
    letter: int, foes: set[int], logic: Logic, links: Links
) -> Iterator[tuple[float, float | None, float | None]]:
    """Return of every green of pedestrians its length, and the times to vehicles' and foes'."""
    stages = logic.stages
    count = len(stages)
    vehicles = {j for own in links for j in own}
    for k, stage in enumerate(stages):
        if stage.state[letter] not in "Gg" or stages[k - 1].state[letter] in "Gg":
            continue
        length = 0
        while length < count and stages[(k + length) % count].state[letter] in "Gg":
            length += 1
        green_s = sum(stages[(k + step) % count].duration_s for step in range(length))
        last = stages[(k + length - 1) % count].state
        to_next_s = to_foe_s = None
        since_s = 0.0
        for step in range(length, count):
            following = stages[(k + step) % count]
            begin = {j for j, now in enumerate(following.state) if _RIGHTS(now) > _RIGHTS(last[j])}
            if to_next_s is None and is_action(following.state, links) and vehicles & begin:
                to_next_s = since_s
            if foes & begin:
                to_foe_s = since_s
                break
            since_s += following.duration_s
        yield green_s, to_next_s, to_foe_s
