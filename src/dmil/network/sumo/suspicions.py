"""What is suspicious about a controller and its program, and greens that conflict."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

from dmil.network.sumo.net_file import read_net_file
from dmil.network.sumo.plan import NO_SEQUENCE, Links, SignalPlan, going, is_action, others_go
from dmil.network.sumo.records import Connection, Logic, NetFile, Remark
from dmil.network.sumo.ways import SumoMovements

LONGEST_ALL_RED_S = 10.0
"""A stage without green that lasts longer is hardly a clearance (ours)."""


def remarks_on(
    logic: Logic, ways: SumoMovements, links: Links, plan: SignalPlan, file: NetFile
) -> Iterator[Remark]:
    """Look for what is suspicious about one controller, and what was made of its program (ours)."""
    place = f"{file.path}: tlLogic {logic.id}"
    if len(logic.programs) > 1:
        yield Remark(
            "several-programs",
            place,
            f"it has the programs {', '.join(logic.programs)}; {logic.programs[-1]} is used, as in "
            "SUMO",
            "remove the others, or load the one you want last",
        )
    if logic.switches:
        times = ", ".join(f"{to} from {when_s:g} s" for when_s, to in logic.switches)
        yield Remark(
            "program-switches",
            place,
            f"a schedule (WAUT) switches its program: {logic.programs[-1]} at the beginning, "
            f"{times}",
            "compare in SUMO, or within the time of one program",
        )
    sequence = logic.kind not in NO_SEQUENCE
    if not sequence:
        yield Remark(
            "own-control",
            place,
            f"its own control ({logic.kind}) is no plan of one stage after the other, and only "
            "SUMO can run it" + ("; its phases are derived from conflicts" if plan.derived else ""),
            "compare with it in SUMO, or give it a static program",
        )
    elif not any(is_action(stage.state, links) for stage in logic.stages):
        yield Remark(
            "no-action",
            place,
            f"no stage of its program ({logic.kind}) gives green to vehicles; its phases are "
            "derived from the conflicts between its movements",
            "give the program a stage with G or g",
        )
    elif not plan.derived and len(plan.phases) == 1:
        yield Remark(
            "single-action",
            place,
            "vehicles have only one phase; there is nothing to choose",
            'read the network with phases="derived", or leave it as it is at a pedestrian crossing',
        )
    for j in sorted(plan.added):
        movement = ways.movements[j]
        yield Remark(
            "never-served",
            place,
            f"no action of its program serves the movement from {movement.from_link} to "
            f"{movement.to_link}; a phase was added for it, but its own program never serves it",
            "give it green in a stage without yellow, or remove the connection",
        )
    if sequence:
        yield from _on_stages(logic, links, place)
    yield from _on_greens(logic, ways, file, place)


def _on_stages(logic: Logic, links: Links, place: str) -> Iterator[Remark]:
    mine = sorted({k for own in links for k in own})
    count = len(logic.stages)
    for index, stage in enumerate(logic.stages):
        where = f"{place}, stage {index}"
        if others_go(stage.state, links):
            yield Remark(
                "pedestrian-stage",
                where,
                f"in {stage.state} only pedestrians or other non-vehicles go, for "
                f"{stage.duration_s:g} s; no phase shows it",
                "give them green together with vehicles that they do not cross",
            )
        elif not going(stage.state, links, "GgyusoO") and stage.duration_s > LONGEST_ALL_RED_S:
            yield Remark(
                "empty-stage",
                where,
                f"in {stage.state} nothing goes for {stage.duration_s:g} s",
                "shorten it to the all-red time that is needed",
            )
        if any(following != (index + 1) % count for following in stage.after):
            yield Remark(
                "stage-order",
                where,
                f"it is followed by stages {', '.join(map(str, stage.after))}, not by the next "
                "one; as a fixed-time plan the stages are taken in the file's order",
                "remove the attribute next, or know that the plan differs from SUMO's",
            )
        following_state = logic.stages[(index + 1) % count].state
        cut = [k for k in mine if stage.state[k] in "Gg" and following_state[k] == "r"]
        if cut:
            yield Remark(
                "missing-yellow",
                where,
                f"green turns red at once: {stage.state} is followed by {following_state} "
                f"(letters {', '.join(map(str, cut))})",
                "put a stage with y between them; where a controller decides, its timing does so",
            )


def _on_greens(logic: Logic, ways: SumoMovements, file: NetFile, place: str) -> Iterator[Remark]:
    pairs = foes_of(logic.id, file, (way for group in ways.connections for way in group))
    for state in dict.fromkeys(stage.state for stage in logic.stages):
        clash = clashing(state, pairs)
        if clash:
            more = f", and {len(clash) - 1} more pairs" if len(clash) > 1 else ""
            yield Remark(
                "conflicting-greens",
                place,
                f"{Clash(logic.id, state, *clash[0])}{more}",
                "write g for the one that yields, or r",
            )


Pair = tuple[Connection, Connection]


def foes_of(signal: str, file: NetFile, connections: Iterable[Connection]) -> list[Pair]:
    """Return the pairs of ways under one controller that cross or merge (ours).

    The connections may be those of other controllers too.
    """
    rows = {(way.junction, way.row): way for way in connections if way.signal == signal}
    return [
        (one, other)
        for (key, one), (key_, other) in combinations(rows.items(), 2)
        if key[0] == key_[0] and key_[1] in file.foes.get(key, ())
    ]


def clashing(state: str, foes: Iterable[Pair]) -> list[Pair]:
    """Return the pairs of ways that both have the right of way, ``G``, in a state (ours)."""
    return [pair for pair in foes if all(state[way.letter] == "G" for way in pair)]


@dataclass(frozen=True, slots=True)
class Clash:
    """Two movements that have the right of way at once in a state, though they conflict (ours)."""

    signal: str
    state: str
    one: Connection
    other: Connection

    def __str__(self) -> str:
        ways = " and ".join(
            f"{way.from_edge} to {way.to_edge} (letter {way.letter})"
            for way in (self.one, self.other)
        )
        return f"in {self.state} the movements {ways} cross or merge, and both have priority"


def first_clash(net_file: str | Path, shown: dict[str, list[str]]) -> Clash | None:
    """Check the states that controllers are to show against the matrices of right of way (ours).

    Lanes of one movement that merge are no clash: their drivers come from one road.

    Raises
    ------
    NetworkError
        If the network cannot be read.
    """
    file = read_net_file(net_file)
    for signal, states in shown.items():
        foes = [
            (one, other)
            for one, other in foes_of(signal, file, file.connections)
            if (one.from_edge, one.to_edge) != (other.from_edge, other.to_edge)
        ]
        for state in dict.fromkeys(states):
            for one, other in clashing(state, foes):
                return Clash(signal, state, one, other)
    return None
