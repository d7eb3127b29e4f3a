"""What an intersection's own plan says of clearance and of the least and longest green."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dmil.network.model import Intersection
from dmil.network.program import Stage

IntArray = npt.NDArray[np.int32]
Clearance = tuple[int, int]
"""Whole seconds of yellow, and of all-red after it."""

YELLOW_S = 3
"""Where a file says nothing: the usual time at 50 km/h, and that of the RESCO benchmark."""
LEAST_GREEN_S = 5
"""Where a file says nothing: the shortest green that netconvert gives (``--tls.min-dur``)."""
LONGEST_MAXIMUM_S = 3600
"""A longest green above it is no limit: SUMO writes some 24 days for none."""


class PlanTimes(NamedTuple):
    """Signal timing of one intersection, in whole seconds (ours).

    Attributes
    ----------
    yellow_s, all_red_s: (phases, phases) int32
        Clearance of the change from a phase (row) to another (column).
    min_green_s, max_green_s: (phases,) int32
        Least green, and the longest one; 0: no limit.
    """

    yellow_s: IntArray
    all_red_s: IntArray
    min_green_s: IntArray
    max_green_s: IntArray


def plan_times(item: Intersection) -> PlanTimes:
    """Read the signal timing out of an intersection's own plan (ours).

    A change that the plan makes takes what it takes there, unless somebody's green turns red at
    once. Any other change takes the longest
    clearance that the plan gives one of the movements that lose their green by it; one that takes
    nobody's green needs none. A phase that the plan shows is green for at least as long as the
    file says (``minDur``), and if it says nothing for 5 s, or less where the plan itself shows it
    for less; the longest green is the file's (``maxDur``), if it has one. Fractions of a second
    count as whole ones. What the plan does not tell is 3 s of yellow and 5 s of green.

    Parameters
    ----------
    item
        The intersection.
    """
    count = len(item.phases)
    changes, movements = _clearances(item)
    usual = _longest(movements.values()) or (max(YELLOW_S, math.ceil(item.clearance_s)), 0)
    yellow_s = np.zeros((count, count), np.int32)
    all_red_s = np.zeros((count, count), np.int32)
    for p, before in enumerate(item.phases):
        for q, after in enumerate(item.phases):
            losing = before - after
            if p == q or not (losing or (before, after) in changes):
                continue
            told = changes.get((before, after))
            if told is None:
                told = _longest(movements.get(j, usual) for j in losing) or usual
            yellow_s[p, q], all_red_s[p, q] = told
    least, longest = np.full(count, LEAST_GREEN_S, np.int32), np.zeros(count, np.int32)
    for p, phase in enumerate(item.phases):
        shown = list(_greens(item, phase))
        if shown:
            least[p] = max(min_s for min_s, _ in shown)
            ends = [max_s for _, max_s in shown]
            if min(ends) > 0 and max(ends) <= LONGEST_MAXIMUM_S:
                longest[p] = max(*ends, least[p])
    return PlanTimes(yellow_s, all_red_s, least, longest)


def _clearances(
    item: Intersection,
) -> tuple[dict[tuple[frozenset[int], frozenset[int]], Clearance], dict[int, Clearance]]:
    """Return the clearance of every change of the plan, and of every movement that loses green."""
    stages = item.program.stages if item.program else ()
    # Where no stage is told to be yellow, the file does not tell yellow from red: all is yellow.
    told = any(stage.yellow for stage in stages)
    changes: dict[tuple[frozenset[int], frozenset[int]], Clearance] = {}
    movements: dict[int, Clearance] = {}
    for before, run, after in _changes(stages):
        if not run and before - after:
            continue  # a green that turns red at once is no example
        whole_s = sum(stage.duration_s for stage in run)
        yellow_s = sum(stage.duration_s for stage in run if stage.yellow) if told else whole_s
        clearance = math.ceil(yellow_s), math.ceil(whole_s) - math.ceil(yellow_s)
        changes[before, after] = _longer(clearance, changes.get((before, after)))
        for j in frozenset().union(before - after, *(stage.yellow for stage in run)):
            movements[j] = _longer(clearance, movements.get(j))
    return changes, movements


def _changes(
    stages: Sequence[Stage],
) -> Iterator[tuple[frozenset[int], list[Stage], frozenset[int]]]:
    """Follow the plan from green to green, with the clearance between them.

    What comes after a green for pedestrians clears them, and not vehicles.
    """
    greens = [k for k, stage in enumerate(stages) if not stage.clearance and stage.green]
    for place, begin in enumerate(greens):
        end = greens[(place + 1) % len(greens)]
        run: list[Stage] = []
        for step in range(1, (end - begin - 1) % len(stages) + 1):
            stage = stages[(begin + step) % len(stages)]
            if stage.others:
                break
            run.append(stage)
        if stages[begin].green != stages[end].green or run:
            yield stages[begin].green, run, stages[end].green


def stops_all(stages: Sequence[Stage], *, untold: bool) -> bool:
    """Tell whether a plan stops everybody at a change of phase, who keeps green too (ours).

    Every movement with green before and after a clearance of the plan counts as an example: either
    it has green in all of it, or it has not. The more frequent kind is the plan's.

    Parameters
    ----------
    stages
        Of the plan.
    untold
        The answer where there is no example, or as many of each kind.
    """
    examples = 0
    for before, run, after in _changes(stages):
        for movement in before & after if run else ():
            kept = all(movement in stage.green for stage in run)
            examples += -1 if kept else 1
    return examples > 0 if examples else untold


def _longer(one: Clearance, other: Clearance | None) -> Clearance:
    """Return a clearance that has the yellow and the whole time of both."""
    if other is None:
        return one
    yellow_s = max(one[0], other[0])
    return yellow_s, max(max(sum(one), sum(other)) - yellow_s, 0)


def _longest(found: Iterable[Clearance]) -> Clearance | None:
    longest: Clearance | None = None
    for clearance in found:
        longest = _longer(clearance, longest)
    return longest


def _greens(item: Intersection, phase: frozenset[int]) -> Iterator[tuple[int, int]]:
    """Return the least and the longest time of every green of a phase; longest 0: no limit."""
    if item.program is None:
        return
    for (green, clearance), group in groupby(
        item.program.stages, key=lambda stage: (stage.green, stage.clearance)
    ):
        if clearance or green != phase:
            continue
        run = list(group)
        whole_s = sum(stage.duration_s for stage in run)
        if item.program.adaptive or any(stage.min_s is not None for stage in run):
            # An actuated program holds a stage without limits for as long as it says.
            min_s = sum(stage.duration_s if stage.min_s is None else stage.min_s for stage in run)
        else:
            min_s = min(LEAST_GREEN_S, whole_s)
        limited = all(stage.max_s is not None for stage in run)
        max_s = sum(stage.max_s or 0.0 for stage in run) if limited else 0.0
        yield max(1, math.ceil(min_s)), math.ceil(max_s)
