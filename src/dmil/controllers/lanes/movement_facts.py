"""The movements of a network, as memories of lanes tell them apart: see `movements`."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from dmil.arrays import ByteArray, FloatArray, IntArray, Single
from dmil.controllers.lanes.lane_groups import LaneGroups
from dmil.controllers.protocol import RunContext

GREEN, ALWAYS = 1, 2
"""Lights of a movement in a phase, beside 0 for red: by its signal, or without one."""


class MovementFacts(NamedTuple):
    """What is known of the movements of a network.

    Attributes
    ----------
    group: (movements,) int32
        Lane group, −1 without a signal.
    capacity_veh: (movements,) float64
        Vehicles that its lanes discharge in a decision interval of green.
    foe_offset: (movements + 1,) int32
        Where those begin that a movement yields to, in ``foes``.
    foes: (foes of all,) int32
        Movements; none where yields do not count.
    light: (phases, movements of the widest intersection) uint8
        0 for red, `GREEN` or `ALWAYS`.
    apart: (some,) int32
        Intersections whose movements have to be told apart.
    interval_s: float
        T.
    """

    group: IntArray
    capacity_veh: FloatArray
    foe_offset: IntArray
    foes: IntArray
    light: ByteArray
    apart: IntArray
    interval_s: float


class MovementMemory(NamedTuple):
    """What is remembered of single movements and groups from one decision to the next.

    Attributes
    ----------
    age_s: (movements,) float32
        A.
    usual_red_s: (intersections,) float32
        R.
    seen_veh: (movements,) float32, or (0,)
        Vehicles queued and approaching, a moving average. This and all that follows is empty where
        no intersection has its movements told apart.
    goes: (movements,) float32, or (0,)
        y under the phase chosen last, 0 at red.
    served, green: (groups,) float32, or (0,)
        φ and c under it.
    """

    age_s: Single
    usual_red_s: Single
    seen_veh: Single
    goes: Single
    served: Single
    green: Single


class MovementWork(NamedTuple):
    """Working space: what is found now.

    Attributes
    ----------
    vehicles: (movements,) float64
        X.
    owed_veh: (movements,) float64
        b.
    goes: (movements,) float64
        y under the phase looked at, 0 at red.
    served, green: (groups,) float64
        φ and c under it.
    """

    vehicles: FloatArray
    owed_veh: FloatArray
    goes: FloatArray
    served: FloatArray
    green: FloatArray


class Movements(NamedTuple):
    """All of it."""

    facts: MovementFacts
    memory: MovementMemory
    work: MovementWork


def movements_of(context: RunContext, groups: LaneGroups, *, yields: bool, age: bool) -> Movements:
    """Return what tells movements apart in a run (ours).

    Parameters
    ----------
    context, groups
        The run, and the lane groups of its network.
    yields
        Whether who has to yield counts less.
    age
        Whether who has waited for long counts more.
    """
    intersections = context.network.intersections
    width = max(len(item.movements) for item in intersections)
    count = width * len(intersections)
    group = np.full(count, -1, np.int32)
    for g, (first, last) in enumerate(pairwise(groups.movement_offset.tolist())):
        group[groups.movements[first:last]] = g
    flow_veh = context.dynamics.saturation_flow_veh_per_s * context.decision_interval_s
    capacity_veh = np.full(count, flow_veh)
    foes: list[tuple[int, ...]] = [()] * count
    light = np.zeros((int(groups.phase_offset[-1]), width), np.uint8)
    apart = []
    for i, item in enumerate(intersections):
        first = i * width
        for j, movement in enumerate(item.movements):
            capacity_veh[first + j] *= max(1, len(movement.lanes))
            if yields and item.gives_way:
                foes[first + j] = tuple(first + k for k in item.gives_way[j])
        for p, phase in enumerate(item.phases, int(groups.phase_offset[i])):
            light[p, list(item.unsignalled)] = ALWAYS
            light[p, list(phase)] = GREEN
        phases = slice(*groups.served_offset[groups.phase_offset[i : i + 2]])
        if (
            groups.all_stop[i]
            or any(foes[first : first + width])
            or (age and groups.partly[phases].any())
        ):
            apart.append(i)
    told, told_groups = (count, groups.lanes.size) if apart else (0, 0)
    return Movements(
        MovementFacts(
            group=group,
            capacity_veh=capacity_veh,
            foe_offset=np.cumsum([0, *map(len, foes)], dtype=np.int32),
            foes=np.array([k for found in foes for k in found], np.int32),
            light=light,
            apart=np.array(apart, np.int32),
            interval_s=float(context.decision_interval_s),
        ),
        MovementMemory(
            age_s=np.zeros(count, np.float32),
            usual_red_s=np.zeros(len(intersections), np.float32),
            seen_veh=np.zeros(told, np.float32),
            goes=np.zeros(told, np.float32),
            served=np.zeros(told_groups, np.float32),
            green=np.zeros(told_groups, np.float32),
        ),
        make_work(count, groups.lanes.size),
    )


def bytes_remembered(movements: Movements, *, age: bool) -> int:
    """Return the memory of what is remembered between decisions, as far as it is used."""
    memory = movements.memory
    used = memory if age else memory[2:]
    return sum(array.nbytes for array in used)


def make_work(movements: int, groups: int) -> MovementWork:
    """Return working space for so many movements and groups."""
    return MovementWork(
        vehicles=np.zeros(movements),
        owed_veh=np.zeros(movements),
        goes=np.zeros(movements),
        served=np.zeros(groups),
        green=np.zeros(groups),
    )
