"""A simulator that watches another one: what all such recorders hand on."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dmil.network import RoadNetwork
from dmil.scenarios import Scenario
from dmil.simulation import Measures, Simulator


class Watching:
    """What a simulator that notes something of another one passes through (ours).

    Parameters
    ----------
    simulator
        The one that simulates.
    """

    def __init__(self, simulator: Simulator) -> None:
        self._simulator = simulator

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
        """Time between two decisions."""
        return self._simulator.decision_interval_s

    @property
    def horizon_s(self) -> int:
        """Time at which a run ends."""
        return self._simulator.horizon_s

    def passed_veh(self) -> npt.NDArray[np.int64]:
        """Return the vehicles that have crossed stop lines: (intersections,) int64."""
        return self._simulator.passed_veh()

    def measures(self) -> Measures:
        """Return what has been measured since the last reset."""
        return self._simulator.measures()
