"""What was understood of every intersection: its approaches, phases, program and symmetries."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from string import ascii_uppercase

from dmil.controllers.tabular.agents import Agents, agents_of
from dmil.doctor.case import Case
from dmil.doctor.load import Load
from dmil.doctor.traffic import Traffic
from dmil.network import TURNS, Intersection
from dmil.network.geometry import RoadGeometry
from dmil.network.lines import heading
from dmil.network.naming import approach_names, phase_name

NEMA = "NEMA"


@dataclass(frozen=True, slots=True)
class Approach:
    """A road into an intersection (ours).

    Parameters
    ----------
    name
        Point of the compass that it comes from.
    link, lanes, length_m
        The link, and how many of its lanes lead on.
    turns
        (turn, lanes that serve it) in the order right, straight, left, u-turn.
    """

    name: str
    link: str
    lanes: int
    length_m: float
    turns: tuple[tuple[str, int], ...]


@dataclass(frozen=True, slots=True)
class Phase:
    """An action (ours).

    Parameters
    ----------
    name
        The movements it serves, such as "N/S F+R".
    planned_green_s
        Seconds of green per cycle, None where the own program never shows it.
    load
        Part of the time that it has to be green in the busiest 15 minutes, None without a demand.
    vehicles
        How many want to go where it leads in all of the run, None without a demand.
    """

    name: str
    planned_green_s: float | None
    load: float | None
    vehicles: int | None


@dataclass(frozen=True, slots=True)
class IntersectionFacts:
    """One intersection as it was understood (ours).

    Parameters
    ----------
    id
        Its id.
    shape
        Letter of its shape: intersections of one letter may share a memory.
    alike
        How many intersections have that shape.
    symmetries
        Size of the symmetry group.
    junctions
        How many junctions the controller governs.
    approaches, movements, phases
        What it consists of.
    unsignalled
        Movements that may always go, in words.
    program_kind
        Kind of its own program, empty if it has none.
    cycle_s, offset_s, stages
        Its own program, as (seconds, index of the phase or None for clearance).
    clearance_s
        Longest clearance in it.
    vehicles
        How many pass it in all of the run, None without a demand.
    load
        What the demand asks of it.
    """

    id: str
    shape: str
    alike: int
    symmetries: int
    junctions: int
    approaches: tuple[Approach, ...]
    movements: int
    phases: tuple[Phase, ...]
    unsignalled: str
    program_kind: str
    cycle_s: float
    offset_s: float
    stages: tuple[tuple[float, int | None], ...]
    clearance_s: float
    vehicles: int | None
    load: Load | None


def intersections_of(case: Case, traffic: Traffic | None) -> tuple[IntersectionFacts, ...]:
    """Describe every intersection, in the network's order (ours)."""
    agents, geometry = agents_of(case.network), RoadGeometry(case.network)
    return tuple(
        _facts(case, i, _side_names(item, geometry), agents, traffic)
        for i, item in enumerate(case.network.intersections)
    )


def _side_names(item: Intersection, geometry: RoadGeometry) -> dict[int, str]:
    """Name the approaches of an intersection after the compass, else by numbers."""
    link_of = {movement.approach: movement.from_link for movement in item.movements}
    sides = sorted(link_of)
    from_rad = [heading(geometry.course(link_of[side])[::-1].tolist()) for side in sides]
    return dict(zip(sides, approach_names(from_rad), strict=True))


def shape_letter(shape: int) -> str:
    """Return A, B, … Z, AA, AB, … for the number of a shape (ours)."""
    more, rest = divmod(shape, len(ascii_uppercase))
    return (shape_letter(more - 1) if more else "") + ascii_uppercase[rest]


def _facts(
    case: Case, i: int, sides: dict[int, str], agents: Agents, traffic: Traffic | None
) -> IntersectionFacts:
    item, shape = case.network.intersections[i], int(agents.shape[i])
    load, crossing = (traffic.load[i], traffic.crossing[i]) if traffic else (None, None)
    planned_s = item.planned_green_s
    program = item.program
    kinds = case.sumo.program_kinds if case.sumo else {}
    return IntersectionFacts(
        id=item.id,
        shape=shape_letter(shape),
        alike=len(agents.members[shape]),
        symmetries=agents.groups[shape].size,
        junctions=case.sumo.junctions.get(item.id, 1) if case.sumo else 1,
        approaches=_approaches(case, item, sides),
        movements=len(item.movements),
        phases=tuple(
            Phase(
                phase_names(item, sides)[p],
                planned_s.get(p),
                load.phase_share[p] if load else None,
                sum(crossing[j] for j in phase) if crossing else None,
            )
            for p, phase in enumerate(item.phases)
        ),
        unsignalled=phase_name(item.unsignalled, item.movements, _listed(sides)),
        program_kind=kinds.get(item.id, "fixed") if program else "",
        cycle_s=program.cycle_s if program else 0.0,
        offset_s=program.offset_s if program else 0.0,
        stages=tuple(
            (
                stage.duration_s,
                item.phases.index(stage.green)
                if stage.green in item.phases and not stage.clearance
                else None,
            )
            for stage in (program.stages if program else ())
        ),
        clearance_s=item.clearance_s,
        vehicles=sum(crossing) if crossing else None,
        load=load,
    )


def phase_names(item: Intersection, sides: Mapping[int, str]) -> tuple[str, ...]:
    """Return a name for every phase, the network's own ones if it has them (ours)."""
    return item.phase_names or tuple(
        phase_name(phase, item.movements, _listed(sides)) for phase in item.phases
    )


def _listed(sides: Mapping[int, str]) -> list[str]:
    return [sides.get(side, str(side)) for side in range(1 + max(sides, default=0))]


def _approaches(case: Case, item: Intersection, sides: Mapping[int, str]) -> tuple[Approach, ...]:
    found = []
    for side, name in sides.items():
        mine = [movement for movement in item.movements if movement.approach == side]
        link = case.network.links[case.network.link_index[mine[0].from_link]]
        lanes = {
            turn: len({lane for each in mine if each.turn == turn for lane in each.lanes})
            for turn in TURNS
        }
        turns = tuple((turn, count) for turn, count in lanes.items() if count)
        used = {lane for each in mine for lane in each.lanes}
        found.append(Approach(name, link.id, len(used), link.length_m, turns))
    return tuple(found)
