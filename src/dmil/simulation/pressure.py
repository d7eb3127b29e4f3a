"""Pressure: the imbalance between a movement's queue and the queues it leads to."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import numpy.typing as npt

from dmil.compilation import kernel
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
    queue = queue_veh.astype(np.float64).ravel()
    on_link, pressure_veh = np.zeros(movements.size), np.empty(queue.size)
    fill_pressure(queue, exit_link, queue_link, movements, on_link, pressure_veh)
    return pressure_veh.reshape(queue_veh.shape)


@kernel
def fill_pressure(
    queue_veh: FloatArray,
    exit_link: IntArray,
    queue_link: IntArray,
    movements: FloatArray,
    on_link: FloatArray,
    pressure_veh: FloatArray,
) -> None:
    """Work out the pressure of every slot; see `movement_pressure`.

    Parameters
    ----------
    queue_veh: (slots,) float64
    exit_link, queue_link: (slots,) int32
        Link that a slot leads to, and link on which its vehicles queue.
    movements: (links + 1,) float64
        Movements from each link, at least 1.
    on_link: (links + 1,) float64
        Zeros; becomes the queue of each link.
    pressure_veh: (slots,) float64
        Filled with the result.
    """
    for slot in range(queue_veh.shape[0]):
        on_link[queue_link[slot]] += queue_veh[slot]
    for slot in range(queue_veh.shape[0]):
        onward = exit_link[slot]
        pressure_veh[slot] = queue_veh[slot] - on_link[onward] / movements[onward]


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
