"""Names of scenarios, as they are looked up and as headings show them."""

import pytest

from dmil.scenarios.names import plain, shown


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("grid:5x5", "grid:5x5"),
        ("resco/cologne1", "resco/cologne1"),
        ("sumo:/a/b/city.sumocfg", "city.sumocfg"),
        ("cityflow:data/jinan_3x4/", "jinan_3x4"),
        ("sumo:", "sumo:"),
    ],
)
def test_of_a_path_headings_show_the_last_part(name, expected):
    assert shown(name) == expected


def test_capitals_do_not_matter_outside_paths():
    assert plain("GRID:5X5") == "grid:5x5"
    assert plain("SUMO:/A/City.sumocfg") == "sumo:/A/City.sumocfg"
