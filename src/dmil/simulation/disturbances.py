"""Runs that are disturbed: sensors that fail or err, and lanes that an incident closes.

`DisturbedSimulator` stands between a simulator and a controller, and is a simulator itself: any
controller can be tested under it, with `dmil.training.evaluate` or its own loop. What is measured
stays the truth.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt
from pydantic import Field

from dmil.arrays import BoolArray, IntArray
from dmil.demand import Vehicles
from dmil.errors import InputError
from dmil.network import RoadNetwork
from dmil.scenarios import Scenario
from dmil.scenarios.timing import Settings
from dmil.seeding import stream
from dmil.simulation.measures import Measures
from dmil.simulation.protocol import Observation, Simulator


class Sensors(Settings):
    """How far a controller's counts are from the truth (ours).

    A detector is what counts the vehicles of one movement, queued and approaching.
    """

    dead_share: float = Field(
        0.0, ge=0, le=1, description="Share of detectors that die and read 0 from then on."
    )
    dead_from_s: int = Field(
        0, ge=0, le=10**9, description="Second in which they die; 0: they are dead for the run."
    )
    missed_share: float = Field(
        0.0, ge=0, le=1, description="Probability that a count misses a vehicle, each by itself."
    )
    false_veh: float = Field(
        0.0,
        ge=0,
        le=1e6,
        allow_inf_nan=False,
        description="Vehicles that a count adds in the mean though nobody is there (Poisson).",
    )


@dataclass(frozen=True, slots=True)
class ClosedLane:
    """A lane that nobody leaves for a while, as behind a broken-down vehicle at its stop line.

    Parameters
    ----------
    link
        Id of the link.
    lane
        Number of the lane, as in `dmil.network.Movement`.
    from_s, until_s
        It closes at the first decision from ``from_s`` on, and opens at ``until_s``.

    Raises
    ------
    InputError
        If it opens before it closes.
    """

    link: str
    lane: int
    from_s: int
    until_s: int

    def __post_init__(self) -> None:
        if not 0 <= self.from_s < self.until_s:
            raise InputError(
                f"it is closed from {self.from_s} to {self.until_s} s",
                where=f"closed lane {self.lane} of link '{self.link}'",
                expected="0 or more, and an end after the beginning",
            )


@runtime_checkable
class ClosesLanes(Protocol):
    """A simulator that can close a lane."""

    def close_lane(self, link: str, lane: int, until_s: int) -> None:
        """Let no vehicle leave a lane from now until a time; the others go on.

        Parameters
        ----------
        link
            Id of the link.
        lane
            Number of the lane.
        until_s
            Second in which it opens.

        Raises
        ------
        InputError
            If no movement of an intersection has such a lane, or no run is under way.
        """


class DisturbedSimulator:
    """A simulator under disturbances (ours).

    Everything random comes from the seed of the run, in streams of its own: dead detectors are the
    same whatever else is disturbed and whoever controls, and a larger share includes a smaller one.

    Parameters
    ----------
    simulator
        What is disturbed.
    sensors
        Errors of what the controller sees. The mean of the vehicles queued over an interval
        (``waiting_veh``) gets the mean error, since over many counts chance evens out.
    closed
        Lanes that are closed for a while.

    Raises
    ------
    InputError
        If lanes are closed and the simulator cannot close any.
    """

    def __init__(
        self,
        simulator: Simulator,
        *,
        sensors: Sensors | None = None,
        closed: Sequence[ClosedLane] = (),
    ) -> None:
        if closed and not isinstance(simulator, ClosesLanes):
            raise InputError(
                f"{type(simulator).__name__} cannot close a lane",
                where="disturbances",
                expected="a simulator with close_lane, such as the queue simulator",
            )
        self._simulator = simulator
        self._sensors = sensors or Sensors()
        self._closed = tuple(closed)
        self._seed = 0
        self._left: list[ClosedLane] = []
        self._movements = _movements(simulator.network)
        self._alive = self._movements

    @property
    def scenario(self) -> Scenario:
        """What is simulated."""
        return self._simulator.scenario

    @property
    def network(self) -> RoadNetwork:
        """The road network that is simulated."""
        return self._simulator.network

    @property
    def decision_interval_s(self) -> int:
        """Time between two decisions, in s."""
        return self._simulator.decision_interval_s

    @property
    def horizon_s(self) -> int:
        """Time at which a run ends, in s."""
        return self._simulator.horizon_s

    @property
    def dead(self) -> BoolArray:
        """Detectors that die in the run under way: (intersections, movements)."""
        return self._movements & ~self._alive

    def reset(self, vehicles: Vehicles, seed: int = 0) -> Observation:
        """Start a run; see `Simulator`."""
        self._seed, self._left = seed, list(self._closed)
        self._alive = self._movements.copy()
        at = np.argwhere(self._movements)
        dead = stream(seed, "sensors", "dead").permutation(len(at))
        at = at[dead[: round(self._sensors.dead_share * len(at))]]
        self._alive[at[:, 0], at[:, 1]] = False
        seen = self._simulator.reset(vehicles, seed)
        self._close(seen.time_s)
        return self._through_sensors(seen)

    def advance(self, phases: npt.NDArray[np.integer]) -> Observation:
        """Show phases for one decision interval; see `Simulator`."""
        seen = self._simulator.advance(phases)
        self._close(seen.time_s)
        return self._through_sensors(seen)

    def passed_veh(self) -> npt.NDArray[np.int64]:
        """Return how many vehicles have crossed each intersection's stop lines, the truth."""
        return self._simulator.passed_veh()

    def measures(self) -> Measures:
        """Return what has been measured since the last reset, the truth."""
        return self._simulator.measures()

    def _close(self, time_s: int) -> None:
        for each in [each for each in self._left if each.from_s <= time_s]:
            self._left.remove(each)
            if each.until_s > time_s and isinstance(self._simulator, ClosesLanes):
                self._simulator.close_lane(each.link, each.lane, each.until_s)

    def _through_sensors(self, seen: Observation) -> Observation:
        sensors = self._sensors
        if sensors == Sensors():
            return seen
        alive = self._alive if seen.time_s >= sensors.dead_from_s else self._movements
        # A stream for each decision: what one count draws depends on no other decision.
        rng = stream(self._seed, "sensors", "counts", seen.time_s)
        missed, false_veh = sensors.missed_share, sensors.false_veh

        def counted(true_veh: IntArray) -> IntArray:
            noisy = rng.binomial(true_veh, 1.0 - missed) + rng.poisson(false_veh, true_veh.shape)
            return np.where(alive, noisy, 0).astype(np.int32)

        return replace(
            seen,
            queue_veh=counted(seen.queue_veh),
            approaching_veh=counted(seen.approaching_veh),
            waiting_veh=np.where(alive, (1.0 - missed) * seen.waiting_veh + false_veh, 0.0),
        )


def first_movement(network: RoadNetwork, link: str, lane: int) -> tuple[int, int]:
    """Return intersection and number of the first movement that goes from a lane (ours).

    Raises
    ------
    InputError
        If no movement of an intersection does.
    """
    lanes: set[int] = set()
    for i, item in enumerate(network.intersections):
        for j, each in enumerate(item.movements):
            if each.from_link == link:
                lanes |= {*each.lanes}
                if lane in each.lanes:
                    return i, j
    raise InputError(
        f"link '{link}' has no lane {lane} before an intersection",
        where=network.name,
        expected=f"one of {sorted(lanes)}" if lanes else "a link that ends at an intersection",
    )


def _movements(network: RoadNetwork) -> BoolArray:
    """Return where tables of (intersections, movements) are no padding."""
    counts = np.array([len(item.movements) for item in network.intersections])
    return np.asarray(np.arange(counts.max()) < counts[:, None])
