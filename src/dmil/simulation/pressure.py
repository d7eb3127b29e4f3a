"""Pressure: the imbalance between a movement's queue and the queues it leads to."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dmil.arrays import FloatArray, IntArray
from dmil.compilation import kernel
from dmil.errors import InputError
from dmil.network import RoadNetwork


def movement_pressure(queue_veh: npt.NDArray[np.integer], network: RoadNetwork) -> FloatArray:
    """Return the pressure of every movement (Varaiya 2013, with equal turning ratios).

    It is the queue of the movement minus the mean queue of the movements that its exit link leads
    to; an exit link of the network has no queue.

    Parameters
    ----------
    queue_veh: (intersections, movements) int
        Vehicles queued; one column per movement of the widest intersection.
    network
        The roads.

    Returns
    -------
    pressure_veh: (intersections, movements) float64

    Raises
    ------
    InputError
        The queues are not those of this network.
    """
    if queue_veh.shape != network.movement_links.shape[1:]:
        raise InputError(
            f"queues of shape {queue_veh.shape}",
            where=f"observation on network '{network.name}'",
            expected=f"{network.movement_links.shape[1:]}: intersections, movements of the widest",
        )
    links, size = network.movement_links.reshape(2, -1), len(network.links) + 1
    queue, pressure_veh = queue_veh.astype(np.float64), np.empty(queue_veh.shape)
    fill_pressure(queue.ravel(), links, np.zeros(size), np.zeros(size), pressure_veh.ravel())
    return pressure_veh


@kernel
def fill_pressure(
    queue_veh: FloatArray,
    movement_links: IntArray,
    on_link: FloatArray,
    movements: FloatArray,
    pressure_veh: FloatArray,
) -> None:
    """Work out the pressure of every movement; see `movement_pressure`.

    Parameters
    ----------
    queue_veh: (movements,) float64
    movement_links: (2, movements) int32
        Link on which the vehicles of a movement queue, and link that it leads to.
    on_link, movements: (links + 1,) float64
        Zeros; become the queue on each link, and the number of movements from it.
    pressure_veh: (movements,) float64
        Filled with the result.
    """
    for movement in range(queue_veh.shape[0]):
        on_link[movement_links[0, movement]] += queue_veh[movement]
        movements[movement_links[0, movement]] += 1.0
    for movement in range(queue_veh.shape[0]):
        onward = movement_links[1, movement]
        pressure_veh[movement] = queue_veh[movement] - on_link[onward] / max(1.0, movements[onward])
