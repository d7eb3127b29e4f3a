"""What SUMO reads and writes: routes, options, outputs."""

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from dmil.demand import Vehicles
from dmil.demand.sumo.beside import Beside
from dmil.simulation.sumo.accounts import Outputs
from dmil.simulation.sumo.files import OWN_KIND, RunFiles, options, write_routes

FILES = RunFiles(
    Path("some.net.xml"),
    ("a&b", "c"),
    (),
    begin_s=100,
    kinds=({}, {"type": "long", "departPos": "last"}),
    beside=Beside(types_xml='<vType id="long" length="12"/>', inner_xml=("", "")),
)


def vehicles(kind):
    links = np.array([0, 1, 1], np.int32)
    return Vehicles(np.array([3, 7], np.int32), np.array([0, 2, 3], np.int32), links, kind=kind)


def test_vehicles_of_a_sumo_scenario_keep_their_attributes(tmp_path):
    write_routes(tmp_path / "r.xml", vehicles(np.array([1, 0], np.int32)), FILES)
    kind, first, second = ElementTree.parse(tmp_path / "r.xml").getroot()
    assert kind.attrib == {"id": "long", "length": "12"}
    assert first.attrib == {"id": "0", "depart": "103", "type": "long", "departPos": "last"}
    assert first[0].attrib == {"edges": "a&b c"}
    assert second.attrib == {"id": "1", "depart": "107"}
    assert second[0].attrib == {"edges": "c"}


def test_other_vehicles_drive_in_with_the_traffic(tmp_path):
    write_routes(tmp_path / "r.xml", vehicles(None), FILES)
    first = ElementTree.parse(tmp_path / "r.xml").getroot()[1]
    assert first.attrib == {"id": "0", "depart": "103", **OWN_KIND}


def test_options_of_the_models():
    def chosen(**changes):
        settings = {"model": "micro", "seed": 5, "emissions": False} | changes
        return options(FILES, Path("r.xml"), **settings)

    micro = chosen()
    assert micro[micro.index("--seed") + 1] == "5"
    assert micro[micro.index("--begin") + 1] == "100"
    assert not {"--mesosim", "--device.emissions.probability"} & set(micro)
    meso = chosen(model="meso")
    assert meso[meso.index("--meso-junction-control") + 1] == "true"
    assert "--device.emissions.probability" in chosen(emissions=True)
    # SUMO's seeds have 31 bits.
    large = chosen(seed=2**31 + 7)
    assert large[large.index("--seed") + 1] == "7"


TRIP = (
    '    <tripinfo id="{}" depart="1" departDelay="2.00" arrival="{}" waitingTime="3.50" '
    'waitingCount="4" timeLoss="5.25" vType="a">\n'
    '        <emissions CO2_abs="1500.0" fuel_abs="500.0"/>\n    </tripinfo>\n'
)


def test_outputs_are_read_piece_by_piece(tmp_path):
    file = tmp_path / "o.xml"
    outputs = Outputs(file)
    whole = "<tripinfos>\n" + TRIP.format(5, 50) + TRIP.format(7, 60)
    # Wherever a piece ends, nothing is lost or read twice.
    for end in range(0, len(whole), 37):
        file.write_text(whole[:end])
        outputs.update()
    file.write_text(whole + TRIP.format(8, -1))
    outputs.update()
    assert outputs.trips.tolist() == [
        [5, 50, 2, 5.25, 3.5, 4, 1.5, 0.5],
        [7, 60, 2, 5.25, 3.5, 4, 1.5, 0.5],
        [8, -1, 2, 5.25, 3.5, 4, 1.5, 0.5],
    ]


def test_outputs_of_a_run_without_vehicles(tmp_path):
    file = tmp_path / "o.xml"
    file.write_text("<tripinfos>\n")
    outputs = Outputs(file)
    outputs.update()
    assert outputs.trips.shape == (0, 8)


@pytest.mark.parametrize("kind", [None, np.zeros(2, np.int32)])
def test_no_vehicle_types_are_needed(kind, tmp_path):
    bare = RunFiles(Path("some.net.xml"), ("a", "b"), (), kinds=({},))
    write_routes(tmp_path / "r.xml", vehicles(kind), bare)
    assert [item.tag for item in ElementTree.parse(tmp_path / "r.xml").getroot()] == [
        "vehicle",
        "vehicle",
    ]
