"""Pressure: the imbalance between a movement's queue and the queues it leads to."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dmil.compilation import kernel
from dmil.errors import InputError
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
        Vehicles queued; as many orientations as the widest intersection has movements.
    network
        The roads.

    Returns
    -------
    pressure_veh: (intersections, orientations) float64

    Raises
    ------
    InputError
        The queues are not those of this network.
    """
    if queue_veh.shape != network.slot_links.shape[1:]:
        raise InputError(
            f"queues of shape {queue_veh.shape}",
            where=f"observation on network '{network.name}'",
            expected=f"{network.slot_links.shape[1:]}: intersections, and movements of the widest",
        )
    links, size = network.slot_links.reshape(2, -1), len(network.links) + 1
    queue, pressure_veh = queue_veh.astype(np.float64), np.empty(queue_veh.shape)
    fill_pressure(queue.ravel(), links, np.zeros(size), np.zeros(size), pressure_veh.ravel())
    return pressure_veh


@kernel
def fill_pressure(
    queue_veh: FloatArray,
    slot_links: IntArray,
    on_link: FloatArray,
    movements: FloatArray,
    pressure_veh: FloatArray,
) -> None:
    """Work out the pressure of every slot; see `movement_pressure`.

    Parameters
    ----------
    queue_veh: (slots,) float64
    slot_links: (2, slots) int32
        Link on which the vehicles of a slot queue, and link that it leads to.
    on_link, movements: (links + 1,) float64
        Zeros; become the queue on each link, and the number of movements from it.
    pressure_veh: (slots,) float64
        Filled with the result.
    """
    for slot in range(queue_veh.shape[0]):
        on_link[slot_links[0, slot]] += queue_veh[slot]
        movements[slot_links[0, slot]] += 1.0
    for slot in range(queue_veh.shape[0]):
        onward = slot_links[1, slot]
        pressure_veh[slot] = queue_veh[slot] - on_link[onward] / max(1.0, movements[onward])
