"""Networks of SUMO that cannot be read: one clear error each."""

import re

import pytest

from dmil.errors import InputError, MissingExtraError, NetworkError
from dmil.network import read_sumo_network
from tests.unit.network.test_network_sumo import NS, PROGRAM


def test_network_without_signals_says_how_to_get_them(generate):
    path = generate("--grid", "--grid.number", "2", "-j", "priority")
    with pytest.raises(NetworkError, match="no traffic light controls vehicles") as caught:
        read_sumo_network(path)
    assert "netconvert" in str(caught.value.mend)
    assert "--tls.guess" in str(caught.value.mend)


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        (' fromLane="0"', "", "its attribute 'fromLane' is missing"),
        ('to="A0top0" fromLane="0"', 'to="A0top0" fromLane="7"', "lane that does not exist"),
        ('to="A0top0" fromLane', 'to="nowhere" fromLane', "names 'nowhere', which is not in"),
        ('speed="13.89" length="76.00"', 'speed="x" length="76.00"', "could not convert"),
        ('speed="13.89" length="76.00"', 'speed="0" length="76.00"', "speed is 0.0 m/s"),
        ('<tlLogic id="A0"', '<tlLogic id="Z"', "no traffic light controls vehicles"),
        ('duration="30"', 'duration="nan"', "is no time"),
        ('duration="30"', 'duration="inf"', "is no time"),
        ('duration="30"', 'duration="x"', "cannot be understood"),
        ('duration="30"', 'duration="-1"', "is no time"),
        ('duration="30"', "", "its attribute 'duration' is missing"),
        (NS, "GG", "stage 0 has 2 letters"),
        ('incLanes="top0A0.80.00_0', 'incLanes="what_0', "there is no lane 'what_0'"),
    ],
)
def test_what_is_wrong_is_named(with_states, old, new, problem):
    path = with_states(*PROGRAM)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(NetworkError, match=re.escape(problem)) as caught:
        read_sumo_network(path)
    assert str(path) in str(caught.value.where)


def test_another_file_and_another_word_are_refused(tmp_path):
    path = tmp_path / "demand.rou.xml"
    path.write_text("<routes/>")
    with pytest.raises(NetworkError, match="this is SUMO routes"):
        read_sumo_network(path)
    with pytest.raises(InputError, match="phases is 'best'"):
        read_sumo_network(path, phases="best")


def test_missing_extra_names_the_command(monkeypatch, tmp_path):
    monkeypatch.setitem(__import__("sys").modules, "sumolib.net", None)
    with pytest.raises(MissingExtraError, match=re.escape("pip install 'dmil[sumo]'")):
        read_sumo_network(tmp_path / "any.net.xml")
