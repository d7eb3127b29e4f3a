"""The paper's grids."""

import pytest

from dmil.errors import NetworkError
from dmil.network import check_network, exit_sides, grid, shape_signature

SIDES = "ENWS"


def test_one_intersection_has_the_papers_orientations_in_order():
    node = grid(1, 1).intersections[0]
    assert node.id == "0,0"
    turns = ("right", "straight", "left")
    assert [(m.approach, m.turn) for m in node.movements] == [
        (side, turn) for side in range(4) for turn in turns
    ]
    assert [m.lanes for m in node.movements] == [(0,), (1,), (2,)] * 4
    for side in range(4):
        here = node.movements[3 * side : 3 * side + 3]
        assert {m.from_link for m in here} == {f"{SIDES[side]}0>0,0"}
        # From the East one drives West: right is North, straight on West, left South.
        assert [m.to_link for m in here] == [f"0,0>{SIDES[(side + k) % 4]}0" for k in (1, 2, 3)]


def test_the_phases_are_the_papers_eight_actions():
    node = grid(1, 1).intersections[0]
    for name, phase in zip(node.phase_names, node.phases, strict=True):
        sides, turns = name.split()
        assert phase == {
            3 * SIDES.index(side) + "RFL".index(turn)
            for side in sides.split("/")
            for turn in turns.split("+")
        }
    assert node.phase_names == (
        "E/W F",
        "E/W L",
        "N/S F",
        "N/S L",
        "E F+L",
        "N F+L",
        "W F+L",
        "S F+L",
    )
    assert {node.movements[j].turn for j in node.unsignalled} == {"right"}
    assert len(node.unsignalled) == 4


def test_fringe_nodes_carry_side_and_row_or_column():
    network = grid(2, 3)
    assert network.name == "grid:2x3"
    assert network.fringe == ("E0", "E1", "N0", "N1", "N2", "W0", "W1", "S0", "S1", "S2")
    links = {link.id for link in network.links}
    # Row 0 is in the North, column 0 in the West.
    assert {"E1>1,2", "1,2>E1", "N0>0,0", "W1>1,0", "S2>1,2", "0,0>1,0", "1,0>0,0"} <= links
    position = network.position_m
    assert position["E0"][0] > position["0,2"][0] > position["0,0"][0] > position["W0"][0]
    assert position["N0"][1] > position["0,0"][1] > position["1,0"][1] > position["S0"][1]


def test_links_between_intersections_take_5_s_and_entries_and_exits_none():
    network = grid(2, 2)
    inner = {node.id for node in network.intersections}
    for link, time_s in zip(network.links, network.free_flow_time_s, strict=True):
        assert time_s == (5.0 if {link.start, link.end} <= inner else 0.0)


def test_all_intersections_of_a_grid_may_share_memory():
    assert len({shape_signature(node) for node in grid(3, 4).intersections}) == 1


def test_movements_leave_by_the_side_of_the_paper():
    network = grid(2, 2)
    for node in network.intersections:
        assert exit_sides(network, node) == tuple(
            (side + step) % 4 for side in range(4) for step in (1, 2, 3)
        )


def test_the_grid_is_consistent():
    check_network(grid(1, 1))
    check_network(grid(3, 2))


@pytest.mark.parametrize("size", [(0, 1), (1, -2), (True, 1), (2.0, 2), ("3", 3)])
def test_a_size_that_is_no_positive_whole_number_is_refused(size):
    with pytest.raises(NetworkError, match="expected a whole number, at least 1"):
        grid(*size)
