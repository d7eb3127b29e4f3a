"""Networks written for SUMO, and read back."""

import importlib.util
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

from dmil.errors import MissingExtraError, NetworkError
from dmil.network import Program, Stage, grid
from dmil.network.sumo import read_sumo_network, write_sumo_network
from dmil.network.sumo.writer import signals_of, stages_of

needs_sumo = pytest.mark.skipif(
    importlib.util.find_spec("sumo") is None or importlib.util.find_spec("sumolib") is None,
    reason="needs the extra sumo",
)


def described(network, names):
    """Movements, phases and unsignalled movements of every intersection, under given link names."""
    return [
        (
            [(names[m.from_link], names[m.to_link], m.turn, m.lanes) for m in item.movements],
            item.phases,
            item.unsignalled,
        )
        for item in network.intersections
    ]


def read_back(network, folder):
    """Write and read; check the signals; return both sides in the same terms."""
    written = write_sumo_network(network, folder)
    found = read_sumo_network(written.net_file)
    order = [found.network.intersection_index[signals.id] for signals in written.signals]
    assert tuple(found.signals[k] for k in order) == written.signals
    edges = dict(zip((link.id for link in network.links), written.edges, strict=True))
    again = replace(
        found.network, intersections=tuple(found.network.intersections[k] for k in order)
    )
    same = {edge: edge for edge in written.edges}
    return found, described(network, edges), described(again, same)


@needs_sumo
def test_a_grid_is_the_same_after_sumo(tmp_path):
    network = grid(3, 3)
    found, wanted, got = read_back(network, tmp_path)
    assert got == wanted
    assert found.remarks == ()
    sides = {item.id: [m.approach for m in item.movements] for item in found.network.intersections}
    assert sides["0_0"] == [m.approach for m in network.intersections[0].movements]
    lengths = {link.length_m for link in found.network.links}
    assert lengths == {50.0, 100.0}  # entries and exits have no length of their own
    assert {link.speed_m_per_s for link in found.network.links} == {10.0}
    assert len(found.network.fringe) == 12
    assert found.network.junctions == ()


@needs_sumo
@pytest.mark.parametrize("name", ["tee", "mixed_network"])
def test_other_shapes_too(name, request, tmp_path):
    _, wanted, got = read_back(request.getfixturevalue(name), tmp_path)
    assert got == wanted


def mirrored(network):
    """The same roads with lanes counted from the left, as CityFlow counts them."""

    def turned(item):
        movements = (replace(m, lanes=tuple(2 - lane for lane in m.lanes)) for m in item.movements)
        return replace(item, movements=tuple(movements))

    return replace(network, intersections=tuple(turned(item) for item in network.intersections))


@needs_sumo
def test_lanes_counted_from_the_left_are_turned_round(tmp_path):
    _, wanted, _ = read_back(grid(1, 2), tmp_path / "right")
    _, _, got = read_back(mirrored(grid(1, 2)), tmp_path / "left")
    assert got == wanted


@needs_sumo
def test_what_netconvert_refuses_is_told(tmp_path):
    network = grid(1, 1)
    links = (replace(network.links[0], speed_m_per_s=-5.0), *network.links[1:])
    with pytest.raises(NetworkError, match=r"grid:1x1: netconvert refuses it: .*Error"):
        write_sumo_network(replace(network, links=links), tmp_path)


def test_a_link_from_a_node_to_itself_cannot_be_written(tmp_path):
    network = grid(1, 1)
    links = (replace(network.links[0], end=network.links[0].start), *network.links[1:])
    with pytest.raises(NetworkError, match="begins and ends at 'E0'"):
        write_sumo_network(replace(network, links=links), tmp_path)


def test_two_nodes_at_one_place_cannot_be_written(tmp_path):
    network = grid(1, 1)
    places = {**network.position_m, "E0": network.position_m["0,0"]}
    with pytest.raises(NetworkError, match="same place"):
        write_sumo_network(replace(network, position_m=places), tmp_path)


def test_without_sumo_the_error_names_the_extra(tmp_path, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(MissingExtraError, match=r"dmil\[sumo\]"):
        write_sumo_network(grid(1, 1), tmp_path)


def test_ids_and_places_fit_sumo(tmp_path, monkeypatch):
    """Two ids that look alike to SUMO stay two; a small picture is enlarged."""
    monkeypatch.setattr("dmil.network.sumo.writer._netconvert", lambda *arguments: None)
    network = grid(1, 1)
    names = {"E0>0,0": "a>b", "0,0>E0": "a,b"}
    item = network.intersections[0]
    movements = tuple(
        replace(
            m,
            from_link=names.get(m.from_link, m.from_link),
            to_link=names.get(m.to_link, m.to_link),
        )
        for m in item.movements
    )
    network = replace(
        network,
        links=tuple(replace(link, id=names.get(link.id, link.id)) for link in network.links),
        intersections=(replace(item, movements=movements),),
        position_m={node: (x / 100, y / 100) for node, (x, y) in network.position_m.items()},
    )
    written = write_sumo_network(network, tmp_path)
    assert written.edges[:2] == ("a_b", "a_b.2")
    nodes = ElementTree.parse(tmp_path / "plain.nod.xml").getroot()
    xs = [float(node.get("x")) for node in nodes]
    assert np.ptp(xs) == pytest.approx(2 * (20 + 8 * 3), abs=0.1)


def crossing(program=None, **changes):
    item = grid(1, 1).intersections[0]
    return replace(item, program=program, **changes)


def test_letters_of_a_phase():
    states = signals_of(crossing(), "x").states
    # Right turns always may go and give way; movements of a phase that do not cross have priority.
    assert states[0] == "gGrgrrgGrgrr"
    assert states[4] == "gGGgrrgrrgrr"


def test_who_gives_way_has_the_small_letter():
    left_and_ahead = (frozenset({1, 8}),)
    assert signals_of(crossing(phases=left_and_ahead), "x").states == ("gGrgrrgrggrr",)
    ways = tuple(() if j != 1 else (8,) for j in range(12))
    told = crossing(phases=left_and_ahead, gives_way=ways)
    assert signals_of(told, "x").states == ("ggrgrrgrGgrr",)


def test_the_own_program_keeps_its_stages():
    first, second = frozenset({1, 7}), frozenset({4, 10})
    program = Program((Stage(30, first), Stage(4, frozenset(), True), Stage(20, second)))
    assert stages_of(crossing(program)) == [
        (30, "gGrgrrgGrgrr"),
        (4, "gyrgrrgyrgrr"),
        # No clearance follows, so that the last of the green is yellow.
        (17, "grrgGrgrrgGr"),
        (3, "grrgyrgrrgyr"),
    ]


def test_without_a_program_each_phase_has_its_turn():
    stages = stages_of(crossing())
    assert [state for _, state in stages[::2]] == list(signals_of(crossing(), "x").states)
    assert {seconds for seconds, _ in stages[::2]} == {20.0}
