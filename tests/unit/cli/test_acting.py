"""What acts on vehicles during SUMO's run, on the command line: the cases, and a warning."""

from pathlib import Path

import pytest

CASES = Path(__file__).parents[2] / "cases"


@pytest.fixture(autouse=True)
def _sumo():
    pytest.importorskip("libsumo", reason="needs the extra sumo")


@pytest.mark.parametrize(
    ("routes", "controller", "delay_s"),
    [
        ("r.rou.xml", "max-pressure", 13.3),
        ("r.rou.xml", "program", 25.7),
        ("r0.rou.xml", "max-pressure", 26.9),
        ("r0.rou.xml", "program", 49.1),
    ],
)
def test_a_rerouting_device_blinds_no_controller(dmil, controller, delay_s, routes):
    """Blind to it 63 of 270 vehicles arrived under max-pressure, with 563 s of delay.

    Under the plan a plain ``sumo`` takes 25.8 s, 52.0 s if the device is taken out (5 seeds).
    """
    folder = CASES / "rerouting-device"
    files = ("--net", folder / "net.net.xml", "--routes", folder / routes, "--steps", 1200)
    found = dmil.json(
        "simulate", *map(str, files), "--simulator", "sumo", "--controller", controller
    )
    (run,) = found["runs"]
    assert (run["spawned_veh"], run["arrived_veh"]) == (270, 270)
    assert run["delay_s"] == pytest.approx(delay_s, abs=0.1)
    warned = "Warning: 150 have a device that sends them elsewhere" in dmil.err
    assert warned == (routes == "r.rou.xml")


@pytest.mark.parametrize("simulator", ["queue", "sumo"])
def test_the_scale_of_a_type_is_sumos_in_both_simulators(dmil, simulator):
    """``sumo -n g.net.xml -r vtype_scale.rou.xml -e 900``: loaded 120, arrived 120."""
    folder = CASES / "vtype-scale"
    files = ("--net", folder / "g.net.xml", "--routes", folder / "vtype_scale.rou.xml")
    found = dmil.json(
        "simulate", *map(str, files), "--steps", "900", "--controller", "program",
        "--simulator", simulator,
    )  # fmt: skip
    assert (found["runs"][0]["spawned_veh"], found["runs"][0]["arrived_veh"]) == (120, 120)
    assert "Warning" not in dmil.err
