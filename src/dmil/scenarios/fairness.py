"""Whether controllers lose as much time at their signals as the plans that they are compared with.

Half of what a controller seems to gain may be clearance that it does not keep: one second less per
change is one second more of green. So what a user gives for all intersections is compared with what
each one's own plan says.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dmil.network import RoadNetwork
from dmil.scenarios.timing import PLAN, SignalTimes, SignalTiming, signal_times


@dataclass(frozen=True, slots=True)
class Advantage:
    """What controllers are spared at one intersection (ours).

    Attributes
    ----------
    intersection: int
        Its index in the network.
    what: str
        ``"clearance"``, ``"all-red"`` or ``"minimum green"``.
    plan_s, given_s: int
        Seconds in its plan, and those that controllers keep; of all changes or phases the ones
        that differ most.
    """

    intersection: int
    what: str
    plan_s: int
    given_s: int

    def __str__(self) -> str:
        return f"{self.what} {self.given_s} s, {self.plan_s} s in its plan"


def safest_times(timing: SignalTiming, network: RoadNetwork) -> SignalTimes:
    """Return times that fall short neither of what is given nor of each plan's own (ours)."""
    given, plan = (signal_times(each, network) for each in (timing, timing.model_copy(update=PLAN)))
    all_red_s = np.maximum(given.all_red_s, plan.all_red_s)
    yellow_s = np.maximum(given.clearance_s - given.all_red_s, plan.clearance_s - plan.all_red_s)
    return SignalTimes(
        clearance_s=yellow_s + all_red_s,
        all_red_s=all_red_s,
        min_green_s=np.maximum(given.min_green_s, plan.min_green_s),
        max_green_s=given.max_green_s,
    )


def advantages(timing: SignalTiming, network: RoadNetwork) -> list[Advantage]:
    """Find where controllers get less lost time than the network's own plans (ours).

    A green lasts for whole decision intervals less the clearance before it, so that it may be long
    enough without a minimum. Intersections without a plan are left out.
    """
    given, plan = (signal_times(each, network) for each in (timing, timing.model_copy(update=PLAN)))
    interval_s = timing.decision_interval_s
    found = []
    for i, item in enumerate(network.intersections):
        if item.program is None or len(item.phases) < 2:
            continue
        own = slice(len(item.phases))
        clearance_s = given.clearance_s[i, own, own]
        # Of every change into a phase: the shortest green that ends with a decision.
        intervals = -(-np.maximum(given.min_green_s[i, own] + clearance_s, 1) // interval_s)
        np.fill_diagonal(intervals, np.iinfo(np.int32).max // interval_s)
        least_s = (intervals * interval_s - clearance_s).min(axis=0)
        for what, theirs, ours in (
            ("clearance", plan.clearance_s[i, own, own], clearance_s),
            ("all-red", plan.all_red_s[i, own, own], given.all_red_s[i, own, own]),
            ("minimum green", plan.min_green_s[i, own], least_s),
        ):
            place = np.unravel_index((theirs - ours).argmax(), theirs.shape)
            if theirs[place] > ours[place]:
                found.append(Advantage(i, what, int(theirs[place]), int(ours[place])))
    return found
