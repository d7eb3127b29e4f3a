"""Every network of the sumo-rl package, the RESCO benchmark among them, reads without a table."""

import xml.etree.ElementTree as ElementTree
from functools import cache

import pytest

from dmil.controllers.tabular.agents import agents_of
from dmil.errors import NetworkError
from dmil.network import TURNS, read_sumo_network
from tests.unit.network.conftest import nets_of_sumo_rl

FILES = sorted(nets_of_sumo_rl().rglob("*.net.xml"))
RESCO = {path.name.removesuffix(".net.xml"): path for path in FILES if "RESCO" in path.parts}


@cache
def read(path, phases):
    """Read a network once for all tests."""
    return read_sumo_network(path, phases=phases)


@cache
def logics(path):
    """Controller to the states of its last program."""
    found = ElementTree.parse(path).getroot().iter("tlLogic")
    return {logic.get("id"): [phase.get("state") for phase in logic] for logic in found}


def test_the_files_are_there():
    assert len(RESCO) == 8
    assert len(FILES) > 15


@pytest.mark.parametrize("phases", ["program", "derived"])
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.parent.name + "-" + path.name)
def test_reads_with_one_intersection_per_controller(path, phases):
    expected = logics(path)
    if not expected:
        with pytest.raises(NetworkError, match="no traffic light"):
            read(path, phases)
        return
    found = read(path, phases)
    assert {node.id for node in found.network.intersections} == set(expected)
    assert [signals.id for signals in found.signals] == [
        node.id for node in found.network.intersections
    ]


@pytest.mark.parametrize("name", RESCO)
def test_phases_are_the_different_greens_of_the_program(name):
    expected = logics(RESCO[name])
    found = read(RESCO[name], "program")
    for node, signals in zip(found.network.intersections, found.signals, strict=True):
        mine = sorted({k for own in signals.links for k in own})
        states = [[s[k] for k in mine] for s in expected[node.id]]
        greens = {tuple(c in "Gg" for c in s) for s in states if not set(s) & {"y", "u"}}
        assert len(node.phases) == len({green for green in greens if any(green)})
        assert node.program is not None
        assert node.clearance_s in (3.0, 5.0)


def test_grid_has_four_rotations_and_its_eight_phases():
    network = read(RESCO["grid4x4"], "program").network
    agents = agents_of(network)
    assert [len(group.phase_image) for group in agents.groups] == [4]
    assert {len(node.phases) for node in network.intersections} == {8}
    assert {node.unsignalled for node in network.intersections} == {frozenset({0, 3, 6, 9})}


def test_turns_of_real_junctions_are_plausible():
    (cologne,) = read(RESCO["cologne1"], "program").network.intersections
    every = [(side, turn) for side in range(4) for turn in TURNS]
    assert [(m.approach, m.turn) for m in cologne.movements] == every
    (ingolstadt,) = read(RESCO["ingolstadt1"], "program").network.intersections
    assert max(m.approach for m in ingolstadt.movements) == 2
    assert {m.turn for m in ingolstadt.movements} >= {"right", "straight", "left"}


def test_only_what_is_suspicious_is_remarked():
    # SUMO warns of the same "unsafe green phase", of two lanes that merge.
    remarks = {
        name: [remark.kind for remark in read(path, "program").remarks]
        for name, path in RESCO.items()
    }
    assert {name: kinds for name, kinds in remarks.items() if kinds} == {
        "ingolstadt21": ["pedestrian-stage", "conflicting-greens"],
        "ingolstadt7": ["conflicting-greens"],
    }
