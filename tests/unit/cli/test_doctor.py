"""``dmil doctor``: what it prints, its exit codes and its pictures."""

import json

import pytest

from dmil.cli.doctor_text import MOST_ROWS, short, sparkline
from dmil.scenarios.names import find_resco_configuration

WIDTH = 80


def flowing(text):
    return " ".join(text.split())


@pytest.fixture
def resco():
    pytest.importorskip("sumolib", reason="needs the extra sumo")
    find_resco_configuration("resco/cologne1")


def test_a_grid_is_described(dmil):
    text = dmil("doctor", "grid:3x3")
    assert max(map(len, text.splitlines())) <= WIDTH
    text = flowing(text)
    assert "48 links, 1.2 km (3.6 km of lanes), 36 km/h" in text
    assert "9 intersections of 1 shape;" in text
    assert "1,1 A E3 N3 W3 S3 12 8 4" in text
    assert "drawn at random" in text
    assert "capacity sufficient: degree of saturation" in text
    assert "no-program × 9" in text
    assert "and 6 more (--all)" in text


def test_many_intersections_are_summarised_by_shape(dmil):
    rows, columns = 5, 5
    assert rows * columns > MOST_ROWS
    short_ = dmil("doctor", f"grid:{rows}x{columns}")
    whole = dmil("doctor", f"grid:{rows}x{columns}", "--all")
    assert "shape number such as" in flowing(short_)
    assert "A 25" in flowing(short_)
    assert "Intersection 4,4" not in short_
    assert whole.count("\nIntersection ") == 25
    assert "more (--all)" not in whole


def test_a_network_of_sumo_is_described(dmil, resco):
    text = dmil("doctor", "resco/cologne3")
    assert max(map(len, text.splitlines())) <= WIDTH
    assert "cologne3.sumocfg, cologne3.net.xml, cologne3.rou.xml" in flowing(text)
    assert "static, cycle 90 s: 38 [0] (3) 6 [1] (3) 37 [2] (3)" in flowing(text)
    assert "25200 s (7:00:00)" in text
    wide = dmil("doctor", "resco/ingolstadt21")
    assert max(map(len, wide.splitlines())) <= WIDTH
    assert "id shape roads in moves phases sym cycle load plan" in flowing(wide)
    assert "cluster_1863241547_1… J" in wide


def test_one_intersection(dmil, resco):
    name = "resco/ingolstadt7"
    cut = short("cluster_1757124350_1757124352")
    text = dmil("doctor", name, "--intersection", cut)
    assert text.startswith("Intersection cluster_1757124350_1757124352")
    assert "gneJ260" not in text
    assert dmil("doctor", name, "--intersection", "cluster_17") == text
    found = dmil.json("doctor", name, "--intersection", "gneJ210")
    assert [each["id"] for each in found["intersections"]] == ["gneJ210"]
    assert [each["kind"] for each in found["findings"]] == ["conflicting-greens"]
    assert "No errors, warnings or notes" in dmil("doctor", name, "--intersection", "gneJ260")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--intersection", "x"), "there is no intersection 'x'; expected one of 0,0, 0,1"),
        (("--intersection", "0,"), "2 intersections begin with '0,'; expected one of 0,0, 0,1."),
        (("--phases", "mine"), "--phases: found 'mine'; expected one of derived, program"),
        (
            ("--routing", "mine"),
            "--routing: found 'mine'; expected one of free-flow, mesoscopic, sumo",
        ),
        (("--begin", "3"), "has no begin, phases or routing to choose"),
        (("--draw", "picture.doc"), "cannot write a figure as '.doc'"),
    ],
)
def test_what_cannot_be_is_said(dmil, arguments, message):
    assert dmil("doctor", "grid:2x2", *arguments, code=2) == ""
    assert message in flowing(dmil.err)


def test_files_that_cannot_be_read_end_with_2(dmil, tmp_path):
    path = tmp_path / "a.net.xml"
    path.write_text("no network")
    dmil("doctor", path, code=2)
    assert "this is not XML" in dmil.err
    dmil("doctor", code=2)


def test_strict_ends_with_1_where_there_is_more_than_notes(dmil, resco):
    dmil("doctor", "grid:2x2", "--strict")
    assert dmil.json("doctor", "resco/cologne3", "--strict", code=1)["findings"]


def test_json_holds_all_of_it(dmil, resco):
    found = dmil.json("doctor", "resco/ingolstadt7", "--begin", "57600", "--steps", "1800")
    assert (found["begin_s"], found["horizon_s"]) == (57600, 1800)
    assert [path.rpartition("/")[2] for path in found["files"]] == [
        f"ingolstadt7.{ending}" for ending in ("sumocfg", "net.xml", "rou.xml")
    ]
    assert len(found["intersections"]) == found["network"]["intersections"] == 7
    item = found["intersections"][0]
    assert item["approaches"][0].keys() == {"name", "link", "lanes", "length_m", "turns"}
    assert item["load"].keys() == {"flow_veh_per_h", "phase_share", "degree", "program_degree"}
    assert sum(found["demand"]["departures"]) == found["demand"]["vehicles"]
    assert all(
        each.keys() == {"kind", "severity", "place", "what", "mend"} for each in found["findings"]
    )


def test_phases_can_be_derived(dmil, resco):
    own, derived = (
        dmil.json("doctor", "resco/cologne1", "--phases", phases)["intersections"][0]["phases"]
        for phases in ("program", "derived")
    )
    assert own != derived


def test_departures_are_drawn_as_bars():
    assert sparkline([0, 1, 7, 14]) == "▁▂▅█"
    assert sparkline([0, 0]) == "▁▁"


BEGINNINGS = {"svg": b"<svg", "png": b"\x89PNG", "pdf": b"%PDF", "html": b"<!DOCTYPE html"}


@pytest.mark.parametrize("ending", BEGINNINGS)
def test_pictures(dmil, tmp_path, ending):
    path = tmp_path / f"picture.{ending}"
    found = json.loads(dmil("doctor", "grid:1x1", "--draw", path, "--json"))
    assert found["drawing"] == str(path)
    assert path.read_bytes().lstrip()[:20].lower().startswith(BEGINNINGS[ending].lower())


def test_the_picture_of_an_intersection_shows_its_phases(dmil, tmp_path):
    path = tmp_path / "picture.svg"
    dmil("doctor", "grid:1x1", "--intersection", "0,0", "--draw", path)
    assert f"Drawing: {path}" in dmil.err
    text = path.read_text()
    for words in ("E/W F", "N/S L", "S F+L", "always open", "E (3 lanes)", "grid:1x1: 0,0"):
        assert f">{words}<" in text, words
