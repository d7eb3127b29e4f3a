"""What a simulator offers and what a controller may see."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from dmil.arrays import IntArray
from dmil.demand import Vehicles
from dmil.network import RoadNetwork
from dmil.scenarios import Scenario
from dmil.simulation.measures import Measures


@dataclass(frozen=True, slots=True)
class Observation:
    """All intersections as a controller may see them at one decision (specification, §2).

    Attributes
    ----------
    queue_veh: (intersections, movements) int32
        Vehicles queued; entries past an intersection's own movements are 0.
    approaching_veh: (intersections, movements) int32
        Vehicles on the link that reach its end within one decision interval.
    phase: (intersections,) int32
        Phase shown; −1 before the first decision and under the intersection's own program.
    phase_elapsed_s: (intersections,) int32
        Time since that phase turned green.
    time_s: int
        Time since the run began.
    waiting_veh: (intersections, movements) float64
        Vehicles queued, averaged over the interval that ended now; 0 at the first decision. Where
        a simulator looks at decisions only (SUMO), the mean of the counts at its two ends.
    """

    queue_veh: IntArray
    approaching_veh: IntArray
    phase: IntArray
    phase_elapsed_s: IntArray
    time_s: int
    waiting_veh: npt.NDArray[np.float64]


class Simulator(Protocol):
    """Moves a scenario on, one decision interval at a time."""

    @property
    def scenario(self) -> Scenario:
        """What is simulated."""

    @property
    def network(self) -> RoadNetwork:
        """The road network that is simulated."""

    @property
    def decision_interval_s(self) -> int:
        """Time between two decisions."""

    @property
    def horizon_s(self) -> int:
        """Time at which a run ends."""

    def reset(self, vehicles: Vehicles, seed: int = 0) -> Observation:
        """Start a run with an empty network and the given journeys; return what is seen at 0 s.

        Parameters
        ----------
        vehicles
            All journeys.
        seed
            Seed of chance inside the simulator, such as differences between drivers.
        """

    def advance(self, phases: npt.NDArray[np.integer]) -> Observation:
        """Show the given phases for one decision interval; return what is seen after it.

        Parameters
        ----------
        phases: (intersections,) int
            Local numbers of phases; `dmil.simulation.timing.PROGRAM` leaves an intersection to its
            own fixed-time program.
        """

    def passed_veh(self) -> npt.NDArray[np.int64]:
        """Return how many vehicles have crossed each intersection's stop lines since the reset.

        Returns
        -------
        (intersections,) int64
        """

    def measures(self) -> Measures:
        """Return what has been measured since the last reset."""
