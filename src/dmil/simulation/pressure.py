"""Pressure: the imbalance between a movement's queue and the queues it leads to."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import numpy.typing as npt

from dmil.network import RoadNetwork

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int32]


def movement_pressure(queue_veh: npt.NDArray[np.integer], network: RoadNetwork) -> FloatArray:
    """Return the pressure of every movement (Varaiya 2013, with equal turning ratios).

    It is the queue of the movement minus the mean queue of the movements that its exit link leads
    to; an exit link of the network has no queue.

    Parameters
    ----------
    queue_veh: (intersections, orientations) int
        Vehicles queued.
    network
        The roads.

    Returns
    -------
    pressure_veh: (intersections, orientations) float64
    """
    exit_link, queue_link, movements = _links_of_slots(network, queue_veh.shape[1])
    on_link = np.bincount(queue_link, queue_veh.ravel(), minlength=movements.size)
    mean_on_link = on_link / movements
    return (queue_veh.ravel() - mean_on_link[exit_link]).reshape(queue_veh.shape)


@lru_cache(maxsize=64)
def _links_of_slots(
    network: RoadNetwork, orientations: int
) -> tuple[IntArray, IntArray, FloatArray]:
    """Return the exit link and the queue's link of every slot, and the movements of every link.

    Padding has an index of its own after those of the links, where nobody ever queues.
    """
    links = len(network.links)
    shape = len(network.intersections), orientations
    exit_link, queue_link = np.full(shape, links, np.int32), np.full(shape, links, np.int32)
    movements = np.zeros(links + 1)
    for i, item in enumerate(network.intersections):
        for j, movement in enumerate(item.movements):
            exit_link[i, j] = network.link_index[movement.to_link]
            queue_link[i, j] = network.link_index[movement.from_link]
            movements[queue_link[i, j]] += 1
    return exit_link.ravel(), queue_link.ravel(), np.maximum(movements, 1.0)
