import numpy as np
import pytest

from dmil.errors import InputError
from dmil.network import grid
from dmil.seeding import stream
from dmil.simulation.pressure import movement_pressure


def literal(queue_veh, network):
    """Return x(j) − mean of x over the movements that continue from the exit link of j."""
    pressure = np.zeros(queue_veh.shape)
    for i, node in enumerate(network.intersections):
        for j, movement in enumerate(node.movements):
            onward = [
                queue_veh[k, m]
                for k, other in enumerate(network.intersections)
                for m, following in enumerate(other.movements)
                if following.from_link == movement.to_link
            ]
            pressure[i, j] = queue_veh[i, j] - (sum(onward) / len(onward) if onward else 0.0)
    return pressure


def test_two_intersections_in_a_row():
    network = grid(1, 2)
    queue_veh = np.zeros((2, 12), np.int32)
    queue_veh[0, 7] = 5  # from the West straight on, to the right-hand intersection
    queue_veh[1, 6:9] = 1, 2, 6  # waiting there, coming from the West
    queue_veh[1, 1] = 4  # from the East straight on, to the left-hand intersection
    pressure_veh = movement_pressure(queue_veh, network)
    assert pressure_veh[0, 7] == 5 - (1 + 2 + 6) / 3
    assert pressure_veh[1, 7] == 2  # its exit leads out of the network
    assert pressure_veh[1, 1] == 4  # nobody waits behind it
    # Whoever else goes to the right-hand intersection meets the same queues.
    assert pressure_veh[0, 3 * 3 + 0] == -3.0
    assert pressure_veh[0, 3 * 1 + 2] == -3.0


def test_a_single_intersection_has_its_queues_as_pressure():
    queue_veh = np.arange(12, dtype=np.int32)[None]
    assert movement_pressure(queue_veh, grid(1, 1)).tolist() == [list(range(12))]


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("name", ["grid", "tee", "mixed_network"])
def test_pressure_is_the_literal_formula(name, seed, request):
    network = grid(2, 3) if name == "grid" else request.getfixturevalue(name)
    most = max(len(node.movements) for node in network.intersections)
    queue_veh = np.zeros((len(network.intersections), most), np.int32)
    for i, node in enumerate(network.intersections):
        count = len(node.movements)
        queue_veh[i, :count] = stream(seed, "pressure", i).integers(0, 30, count)
    pressure_veh = movement_pressure(queue_veh, network)
    np.testing.assert_allclose(pressure_veh, literal(queue_veh, network), atol=1e-12)
    for i, node in enumerate(network.intersections):
        assert (pressure_veh[i, len(node.movements) :] == 0).all()


@pytest.mark.parametrize("shape", [(2, 16), (2, 11), (1, 12)])
def test_queues_of_another_network_are_refused(shape):
    with pytest.raises(InputError, match=r"queues of shape .* expected \(2, 12\)"):
        movement_pressure(np.zeros(shape, np.int32), grid(1, 2))
