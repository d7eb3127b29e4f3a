"""What is measured in a run, by one definition for every simulator."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt


@dataclass(frozen=True, slots=True)
class Measures:
    """Raw counts of a run, from which every metric follows (specification, §3).

    Attributes
    ----------
    time_s: int
        How long the run has lasted.
    spawned_veh, arrived_veh: int
        Vehicles that departed, and of these those at their destination (V_c).
    wait_veh_s: int
        Vehicle-seconds queued or waiting outside for room, vehicles still waiting included.
    visits: int
        Times that a vehicle joined a queue.
    arrived_wait_veh_s: int
        Vehicle-seconds that the arrived vehicles waited.
    travel_veh_s: int
        Time from departure to arrival over all spawned vehicles; a vehicle that has not arrived
        counts up to the end of the run.
    refused_changes: int
        Phase changes that the signal timing rules refused.
    arrived_at, queued_at: (time_s,) int32
        V_c and vehicles waiting, outside included, after each second.
    """

    time_s: int
    spawned_veh: int
    arrived_veh: int
    wait_veh_s: int
    visits: int
    arrived_wait_veh_s: int
    travel_veh_s: int
    refused_changes: int
    arrived_at: npt.NDArray[np.int32]
    queued_at: npt.NDArray[np.int32]

    @property
    def wait_per_spawned_s(self) -> float:
        """W: mean time queued per spawned vehicle, in s."""
        return _ratio(self.wait_veh_s, self.spawned_veh)

    @property
    def w_over_vc(self) -> float:
        """W / V_c at the end of the run: the paper's normalised waiting time (Table II)."""
        return _ratio(self.wait_per_spawned_s, self.arrived_veh)

    @property
    def wait_per_visit_s(self) -> float:
        """Mean time queued per intersection visit, in s."""
        return _ratio(self.wait_veh_s, self.visits)

    @property
    def wait_per_arrived_s(self) -> float:
        """Mean time queued of the vehicles that arrived, in s."""
        return _ratio(self.arrived_wait_veh_s, self.arrived_veh)

    @property
    def mean_queue_veh(self) -> float:
        """Vehicles waiting in the network, averaged over the run."""
        return _ratio(self.wait_veh_s, self.time_s)

    @property
    def travel_time_s(self) -> float:
        """Mean travel time, in s; unfinished vehicles count up to the end of the run."""
        return _ratio(self.travel_veh_s, self.spawned_veh)

    @property
    def throughput_veh_per_h(self) -> float:
        """Vehicles that arrived, per hour."""
        return _ratio(self.arrived_veh * 3600, self.time_s)


def _ratio(value: float, count: float) -> float:
    """Divide; a mean over nothing is NaN."""
    return value / count if count else float("nan")
