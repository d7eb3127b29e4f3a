"""What is measured in a run, by one definition for every simulator.

The catalogue `dmil.results.metrics` says what the metrics are called and how they are shown.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

NAN = float("nan")


@dataclass(frozen=True, slots=True)
class Measures:
    """Raw counts of a run, from which every metric follows (specification, §3).

    Attributes
    ----------
    time_s: int
        How long the run has lasted.
    spawned_veh, arrived_veh: int
        Vehicles whose departure time has come, whether or not they found room to enter, and of
        these those at their destination (V_c).
    wait_veh_s: float
        Vehicle-seconds queued or waiting outside for room, vehicles still waiting included.
    visits: int
        Times that a vehicle joined a queue.
    arrived_wait_veh_s: float
        Vehicle-seconds that the arrived vehicles waited.
    travel_veh_s: float
        Time from departure to arrival over all spawned vehicles; a vehicle that has not arrived
        counts up to the end of the run.
    time_loss_veh_s: float
        Vehicle-seconds that vehicles inside the network lost against driving freely.
    departure_delay_veh_s: float
        Vehicle-seconds between the scheduled departure and entering the network; vehicles that have
        not entered count up to the end of the run.
    stops: int
        Times that a vehicle inside the network came to a halt.
    overruled: int
        Requests for phases that the signal timing rules did not grant.
    arrived_at, queued_at: (time_s,) int32
        V_c and vehicles waiting, outside included, after each second.
    co2_g, fuel_g: float
        Emissions and fuel in g; NaN where the simulator does not know.
    person_delay_s: float
        Mean time that a person who walks stands still, in s; NaN where nobody walks.
    last_minus_first_s, entering_lanes_s: float
        Time at intersections by the counts of published codes for CityFlow, mean over vehicles, in
        s; NaN in other simulators.
    """

    time_s: int
    spawned_veh: int
    arrived_veh: int
    wait_veh_s: float
    visits: int
    arrived_wait_veh_s: float
    travel_veh_s: float
    time_loss_veh_s: float
    departure_delay_veh_s: float
    stops: int
    overruled: int
    arrived_at: npt.NDArray[np.int32]
    queued_at: npt.NDArray[np.int32]
    co2_g: float = NAN
    fuel_g: float = NAN
    person_delay_s: float = NAN
    last_minus_first_s: float = NAN
    entering_lanes_s: float = NAN

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
        """Vehicles waiting, averaged over the run."""
        return _ratio(self.wait_veh_s, self.time_s)

    @property
    def travel_time_s(self) -> float:
        """Mean travel time, in s; unfinished vehicles count up to the end of the run."""
        return _ratio(self.travel_veh_s, self.spawned_veh)

    @property
    def delay_s(self) -> float:
        """Mean delay as RESCO defines it: time loss and departure delay, unfinished included."""
        return _ratio(self.time_loss_veh_s + self.departure_delay_veh_s, self.spawned_veh)

    @property
    def throughput_veh_per_h(self) -> float:
        """Vehicles that arrived, per hour."""
        return _ratio(self.arrived_veh * 3600, self.time_s)

    @property
    def stops_per_spawned(self) -> float:
        """Mean number of stops per spawned vehicle."""
        return _ratio(self.stops, self.spawned_veh)


def _ratio(value: float, count: float) -> float:
    """Divide; a mean over nothing is NaN."""
    return value / count if count else NAN
