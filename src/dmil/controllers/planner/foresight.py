"""A planner that knows every arrival: how good control of one intersection can be at most.

It is an upper bound for comparison, not a rival: it knows the future. At the beginning of a run it
works out when every vehicle will reach the stop line, searches the phases up to the last arrival
with the queue simulator's own dynamics (`dmil.controllers.planner.beam`), and then shows them. At
every decision it compares the waiting that it planned with what is seen: a run that does not follow
the plan to the vehicle-second ends with an error instead of a limit that is none.

Source: ours. Beam search gives no proof that nothing is better; where the result does not change
with the width, it is the optimum as far as anybody can tell.
"""

from __future__ import annotations

import math
from collections import Counter
from itertools import pairwise

import numpy as np
from pydantic import Field

from dmil.arrays import FloatArray, IntArray
from dmil.controllers.parameters import Settings
from dmil.controllers.planner.beam import search
from dmil.controllers.planner.crossing import KnownIntersection
from dmil.controllers.protocol import RunContext
from dmil.controllers.rules.phase_choice import PhaseChoice, signalled
from dmil.errors import InputError
from dmil.network import Intersection
from dmil.scenarios import signal_times, uniform_timing
from dmil.simulation import Observation

WHERE = "controller 'foresight'"


class ForesightSettings(Settings):
    """The planner."""

    width: int = Field(
        default=1000,
        ge=1,
        le=1_000_000,
        description="Beam width: states kept at every decision.",
    )


class ForesightController:
    """Shows the phases that it found best for the arrivals to come, on a single intersection.

    Once the plan is over, after the last arrival, the longest queues are served first.

    Attributes
    ----------
    planned_veh_s: (decisions,) int64
        Vehicle-seconds waited in every interval of the plan.
    """

    def __init__(self, settings: ForesightSettings | None = None) -> None:
        self.settings = settings or ForesightSettings()

    def reset(self, context: RunContext) -> None:
        """Plan the run.

        Raises
        ------
        InputError
            If the scenario is not one that it can foresee; the error says why.
        """
        self._interval_s = context.decision_interval_s
        self._afterwards = PhaseChoice(context.network, context.timing, 0.0)
        self._plan, self.planned_veh_s = search(crossing_of(context), self.settings.width)

    def decide(self, observation: Observation, reward: FloatArray | None) -> IntArray:
        """Look up the planned phase.

        Raises
        ------
        InputError
            If the run does not follow the plan.
        """
        decision = observation.time_s // self._interval_s
        if 0 < decision <= self._plan.size:
            seen_veh_s = float(observation.waiting_veh.sum()) * self._interval_s
            planned_veh_s = int(self.planned_veh_s[decision - 1])
            if abs(seen_veh_s - planned_veh_s) > 1e-3:
                raise InputError(
                    f"the run does not follow its plan: in the {self._interval_s} s up to "
                    f"{observation.time_s} s {seen_veh_s:g} vehicle-seconds were waited",
                    where=WHERE,
                    expected=f"the {planned_veh_s} that it planned",
                    mend="use it with the queue simulator, without a calibration of link times",
                )
        if decision < self._plan.size:
            return self._plan[decision : decision + 1].copy()
        return self._afterwards.best(observation.queue_veh, observation.phase)


def crossing_of(context: RunContext) -> KnownIntersection:
    """Return what a search needs to know of a run (ours).

    Raises
    ------
    InputError
        If the scenario has more than one intersection, storage, lanes that movements share,
        movements that give way, or lost time beyond a decision interval; or if the journeys are not
        known, or one crosses the intersection twice.
    """
    timing, network = context.timing, context.network
    if len(network.intersections) != 1:
        raise _refusal(f"the network has {len(network.intersections)} intersections", "one")
    item = network.intersections[0]
    rules = uniform_timing(timing, network, 0)
    if any(times.min() != times.max() for times in signal_times(timing, network)):
        raise _refusal(
            "clearance or greens differ from phase to phase, as in its plan",
            "the same for all, as --clearance, --all-red, --min-green and --max-green give them",
        )
    lost_s = rules.clearance_s + rules.startup_lost_s
    if lost_s > timing.decision_interval_s:
        raise _refusal(
            f"clearance and start-up take {lost_s} s",
            f"at most the decision interval, {timing.decision_interval_s} s",
        )
    if context.dynamics.storage:
        raise _refusal("links hold a finite number of vehicles", "QueueDynamics(storage=False)")
    _check_lanes(item)
    unsignalled = np.zeros(len(item.movements), np.bool_)
    unsignalled[list(item.unsignalled)] = True
    lanes = [0, *(len(movement.lanes) for movement in item.movements)]
    return KnownIntersection(
        served=signalled(network)[0],
        unsignalled=unsignalled,
        lane_offset=np.cumsum(lanes).astype(np.int32),
        arriving_veh=_arrivals(context),
        headway_s=1 / context.dynamics.saturation_flow_veh_per_s,
        rules=rules,
    )


def _refusal(found: str, expected: str) -> InputError:
    return InputError(
        found, where=WHERE, expected=expected, mend="use it on a scenario such as grid:1x1"
    )


def _check_lanes(item: Intersection) -> None:
    users = Counter((m.from_link, lane) for m in item.movements for lane in m.lanes)
    shared = [(link, lane) for (link, lane), count in users.items() if count > 1]
    if shared:
        link, lane = shared[0]
        raise _refusal(
            f"several movements share lane {lane} of link '{link}'", "lanes of their own"
        )
    if any(item.gives_way):
        raise _refusal("movements give way to others", "movements that do not")


def _arrivals(context: RunContext) -> IntArray:
    """Return how many vehicles reach the stop line in every second up to the last one.

    Returns
    -------
    arriving_veh: (seconds, movements) int32
        The seconds fill whole decision intervals.
    """
    network, vehicles = context.network, context.vehicles
    if vehicles is None:
        raise _refusal("it does not get the journeys of the run", "RunContext.vehicles")
    link_s = network.free_flow_time_s
    seconds: list[int] = []
    movements: list[int] = []
    for vehicle, depart_s in enumerate(vehicles.depart_s.tolist()):
        route = vehicles.route(vehicle).tolist()
        crossed = [network.movement_index.get(pair) for pair in pairwise(route)]
        met = [(k, place[1]) for k, place in enumerate(crossed) if place is not None]
        if len(met) > 1:
            raise _refusal(f"vehicle {vehicle} crosses the intersection {len(met)} times", "once")
        for k, movement in met:
            seconds.append(depart_s + round(float(link_s[route[: k + 1]].sum())))
            movements.append(movement)
    interval_s = context.decision_interval_s
    decisions = math.ceil((max(seconds, default=-1) + 1) / interval_s)
    shape = decisions * interval_s, len(network.intersections[0].movements)
    arriving_veh = np.zeros(shape, np.int32)
    places = np.array(seconds, np.int64), np.array(movements, np.int64)
    np.add.at(arriving_veh, places, 1)
    return arriving_veh
