"""Every inconsistency of a network has its own message."""

import math
from dataclasses import replace

import pytest

from dmil.errors import NetworkError
from dmil.network import Junction, Link, Movement, Program, Stage, check_network, grid

NETWORK = grid(1, 2)
LINK = NETWORK.links[0]
NODE = NETWORK.intersections[0]
MOVEMENT = NODE.movements[0]


def with_link(**change):
    return replace(NETWORK, links=(replace(LINK, **change), *NETWORK.links[1:]))


def with_node(**change):
    return replace(NETWORK, intersections=(replace(NODE, **change), *NETWORK.intersections[1:]))


def with_movement(index=0, **change):
    movements = list(NODE.movements)
    movements[index] = replace(movements[index], **change)
    return with_node(movements=tuple(movements))


def with_junction(link):
    """A junction without signals, whose only movement comes from a link that ends elsewhere."""
    ways = (Movement(link, "0,0>0,1", "straight", 0, (0,)),)
    return replace(
        NETWORK,
        junctions=(Junction("J", ways),),
        position_m={**NETWORK.position_m, "J": (0.0, 0.0)},
    )


def plan(duration_s, green):
    return Program((Stage(duration_s, frozenset(green)),))


def with_phases(*phases):
    return with_node(phases=tuple(map(frozenset, phases)), phase_names=())


@pytest.mark.parametrize(
    ("network", "message"),
    [
        (replace(NETWORK, intersections=()), "there is no intersection"),
        (replace(NETWORK, links=(LINK, *NETWORK.links)), f"2 links are named '{LINK.id}'"),
        (replace(NETWORK, fringe=("E0", "E0")), "2 nodes are named 'E0'"),
        (replace(NETWORK, fringe=(*NETWORK.fringe, "0,0")), "2 nodes are named '0,0'"),
        (with_link(start="Z"), "starts at 'Z', which is neither an intersection nor a fringe"),
        (with_link(end="Z"), "ends at 'Z', which is neither an intersection nor a fringe"),
        (with_link(length_m=-1.0), "length is -1.0 m; expected a number of 0 m or more"),
        (with_link(length_m=math.nan), "length is nan m"),
        (with_link(length_m=math.inf), "length is inf m"),
        (with_link(speed_m_per_s=0.0), "speed is 0.0 m/s; expected a number above 0 m/s"),
        (with_link(speed_m_per_s=math.nan), "speed is nan m/s"),
        (with_link(lanes=0), "it has 0 lanes; expected a whole number"),
        (with_link(lanes=1.5), "it has 1.5 lanes; expected a whole number"),
        (replace(NETWORK, position_m={}), "node 0,0: its position is missing"),
        (
            replace(NETWORK, position_m={**NETWORK.position_m, "E0": (math.nan, 0.0)}),
            "node E0: its position is missing or not finite",
        ),
        (with_node(movements=()), "it has no movements"),
        (with_movement(from_link="nowhere"), "movement 0: there is no link 'nowhere'"),
        (with_movement(to_link="nowhere"), "movement 0: there is no link 'nowhere'"),
        (with_movement(from_link="E0>0,1"), "comes from link E0>0,1, which ends at '0,1'"),
        (with_movement(to_link="0,1>E0"), "goes to link 0,1>E0, which starts at '0,1'"),
        (with_movement(turn="back"), "its turn is 'back'; expected one of right, straight"),
        (with_movement(approach=-1), "its approach is -1; expected 0 or more"),
        (with_movement(approach=2), "name the approaches 2 and 0; expected one approach"),
        (with_movement(lanes=()), r"its lanes are \[\]; expected at least one lane of link"),
        (with_movement(lanes=(1, 1)), r"its lanes are \[1, 1\]; expected .* each once"),
        (with_movement(lanes=(3,)), r"its lanes are \[3\]; expected lanes from 0 to 2"),
        (with_movement(lanes=(-1,)), r"its lanes are \[-1\]; expected lanes from 0 to 2"),
        (
            with_node(movements=(*NODE.movements, MOVEMENT)),
            f"2 movements are named '{MOVEMENT.from_link} to {MOVEMENT.to_link}'",
        ),
        (with_phases(), "it has no phases. Add one"),
        (with_node(unsignalled=frozenset({12})), "movement 12 is unsignalled but does not exist"),
        (with_phases({1, 2}, ()), "phase 1: it serves no movement. Remove it"),
        (with_phases({1, 2}, {12}), "phase 1: it serves movement 12, which does not exist"),
        (with_phases({0, 1}), "serves movement 0, which is unsignalled"),
        (with_phases({1, 2}, {4}, {2, 1}), "phase 2: it serves the same movements as phase 0"),
        (
            with_phases({1, 2, 4, 5, 7, 8, 10}),
            r"movement 11 \(S0>0,0 to 0,0>W0\) is served by no phase",
        ),
        (with_node(program=plan(5.0, {12})), "its stage 0 serves movement 12; expected 0 to 11"),
        (with_node(program=plan(0.0, {1})), "its stage 0 lasts 0.0 s"),
        (with_node(program=Program(())), "its program has no stages"),
        (with_node(gives_way=((1,),)), "it says for 1 movements that they yield to"),
        (with_node(gives_way=((12,),) + ((),) * 11), "conflict with movement 12; expected 0 to 11"),
        (with_node(conflicts=frozenset({(0, 12)})), "conflict with movement 12"),
        (
            with_node(gives_way=((1,), (2,), (0,)) + ((),) * 9),
            "movements 0, 1, 2 yield to each other in a circle",
        ),
        (with_junction("0,0>0,1"), "it comes from link 0,0>0,1, which ends at '0,1'"),
        (with_node(phase_names=("one",)), "1 names for 8 phases"),
        (with_node(clearance_s=-1.0), "its clearance is -1.0 s"),
        (with_node(clearance_s=math.nan), "its clearance is nan s"),
    ],
)
def test_an_inconsistent_network_is_refused(network, message):
    with pytest.raises(NetworkError, match=message) as caught:
        check_network(network)
    assert str(caught.value).startswith("grid:1x2")


def test_the_error_names_the_file_if_there_is_one():
    with pytest.raises(NetworkError, match=r"^city\.json: link .*its speed"):
        check_network(with_link(speed_m_per_s=-1.0), where="city.json")


def test_a_link_between_fringe_nodes_is_allowed():
    bypass = Link("bypass", "W0", "E0", 10.0, 10.0, 1)
    check_network(replace(NETWORK, links=(*NETWORK.links, bypass)))
