"""What upstream intersections announce: the vehicles that will join a queue next."""

from __future__ import annotations

import numpy as np

from dmil.arrays import BoolArray, FloatArray, IntArray
from dmil.controllers.protocol import RunContext
from dmil.simulation import Observation
from dmil.simulation.timing import signals_of


class Announcements:
    """Predicts queues one decision ahead, if all signals stay as they are (ours).

    A movement with green discharges its queue at the saturation flow of its lanes. What it
    discharges spreads evenly over the movements of the link that it leads to, because who turns
    where is not known, and joins the queues there if it arrives within the interval.
    """

    def __init__(self, context: RunContext) -> None:
        network, dynamics = context.network, context.dynamics
        interval_s, signals = context.decision_interval_s, signals_of(network)
        self._queue_link, self._exit_link = network.movement_links
        self._flow_veh_per_s = np.zeros(signals.unsignalled.shape)
        # The last row is that of no phase: only what needs no signal is served.
        self._served = np.concatenate([signals.served, signals.unsignalled[:, None]], axis=1)
        for i, item in enumerate(network.intersections):
            for j, movement in enumerate(item.movements):
                lanes = max(1, len(movement.lanes))
                self._flow_veh_per_s[i, j] = dynamics.saturation_flow_veh_per_s * lanes
        on_link = np.bincount(self._queue_link.ravel(), minlength=len(network.links) + 1)
        self._movements = np.maximum(on_link, 1)
        travel_s = np.array([link.free_flow_time_s for link in network.links])
        self._interval_s = interval_s
        # Who leaves later than this arrives after the interval.
        self._in_time_s = np.append(np.clip(interval_s - travel_s, 0.0, None), 0.0)

    def queue_ahead(self, observation: Observation) -> IntArray:
        """Return queue − served + announced inflow, in whole vehicles: (intersections, movements).

        Announced are those who approach, and those who will leave an upstream intersection early
        enough to arrive.
        """
        queue = observation.queue_veh
        served = self._served_by(observation.phase)
        leaving = np.where(served, np.minimum(queue, self._flow_veh_per_s * self._interval_s), 0.0)
        inflow = self._inflow_veh(queue, served)
        ahead: FloatArray = queue - leaving + observation.approaching_veh + inflow
        return np.floor(ahead + 0.5).astype(np.int32)

    def queue_with_inflow(self, observation: Observation, phases: IntArray) -> IntArray:
        """Return queue + announced inflow, in whole vehicles: (intersections, movements) (ours).

        What an intersection has to serve until it decides again, whatever it does itself.

        Parameters
        ----------
        observation
            What is seen now.
        phases: (intersections,) int32
            What is announced.
        """
        queue = observation.queue_veh
        inflow = self._inflow_veh(queue, self._served_by(phases))
        full: FloatArray = queue + observation.approaching_veh + inflow
        return np.floor(full + 0.5).astype(np.int32)

    def _served_by(self, phases: IntArray) -> BoolArray:
        served: BoolArray = self._served[np.arange(phases.size), phases]
        return served

    def _inflow_veh(self, queue: IntArray, served: BoolArray) -> FloatArray:
        soon_s = self._in_time_s[self._exit_link]
        arriving: FloatArray = np.where(
            served, np.minimum(queue, self._flow_veh_per_s * soon_s), 0.0
        )
        on_link = np.bincount(
            self._exit_link.ravel(), arriving.ravel(), minlength=self._movements.size
        )
        inflow: FloatArray = (on_link / self._movements)[self._queue_link]
        inflow[self._queue_link == self._movements.size - 1] = 0.0
        return inflow
