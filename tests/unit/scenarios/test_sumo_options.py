"""The table of SUMO's options, and configurations as SUMO reads them."""

import subprocess
from pathlib import Path
from xml.etree import ElementTree

import pytest

from dmil.errors import InputError
from dmil.network.sumo.writer import sumo_program
from dmil.scenarios import read_sumo_configuration
from dmil.scenarios.sumo_options import GROUPS, OPTIONS

FILES = '<n value="a.net.xml"/><r value="a.rou.xml"/>'


def written(folder, text):
    path = folder / "a.sumocfg"
    path.write_text(text)
    return path


def test_every_option_of_the_installed_sumo_is_in_the_table(tmp_path):
    pytest.importorskip("sumo", reason="needs the extra sumo")
    program, environment = sumo_program("sumo")
    template = tmp_path / "template.xml"
    command = [str(program), "--save-template", str(template)]
    subprocess.run(command, check=True, capture_output=True, env=environment, timeout=120)
    found = [option for section in ElementTree.parse(template).getroot() for option in section]
    assert len(found) > 400
    for option in found:
        names = [option.tag, *option.get("synonymes", "").split()]
        assert {OPTIONS[name].name for name in names} == {option.tag}
        ours = OPTIONS[option.tag]
        if ours.treatment in ("noted", "refused"):
            assert ours.default == option.get("value"), option.tag
    text = template.read_text().replace('net-file value=""', 'net-file value="a.net.xml"')
    text = text.replace('route-files value=""', 'route-files value="a.rou.xml"')
    read = read_sumo_configuration(written(tmp_path, text))
    assert (read.unused, read.begin_s, read.end_s) == ((), 0, None)


def test_a_name_stands_for_one_option_and_every_group_has_a_reason():
    words = [word.partition("=")[0].split("|") for g in GROUPS for word in g.names.split()]
    names = [name for group in words for name in group]
    assert len(names) == len(set(names)) == len(OPTIONS)
    assert all(group.reason for group in GROUPS)


def test_names_of_sections_and_of_the_root_do_not_matter(tmp_path):
    text = f"<mine>{FILES}<gui_only><begin>60</begin></gui_only><odd><e value='90'/></odd></mine>"
    found = read_sumo_configuration(written(tmp_path, text))
    assert (found.net_file, found.begin_s, found.end_s) == (tmp_path / "a.net.xml", 60, 90.0)


def test_variables_of_the_environment_are_put_in(tmp_path, monkeypatch):
    monkeypatch.setenv("CITY", "bonn")
    monkeypatch.delenv("GONE", raising=False)
    text = '<x><net-file value="${CITY}/${GONE}a.net.xml"/><r value="${CITY}-${PID}.xml"/></x>'
    found = read_sumo_configuration(written(tmp_path, text))
    assert found.net_file == tmp_path / "bonn" / "a.net.xml"
    assert found.route_files[0].name.removeprefix("bonn-").removesuffix(".xml").isdigit()


def test_options_are_told_to_sumo_named_or_passed_over(tmp_path):
    text = f"""<configuration>{FILES}<processing><lateral-resolution value="0.8"/>
    <time-to-teleport value="300"/><max-depart-delay value="60"/></processing>
    <output><summary value="s.xml"/></output><report><verbose value="true"/></report>
    <seed value="7"/><osg-view value="true"/></configuration>"""
    found = read_sumo_configuration(written(tmp_path, text))
    assert found.for_sumo == (("lateral-resolution", "0.8"), ("time-to-teleport", "300"))
    assert found.unused == ("max-depart-delay=60",)


def test_vehicles_may_stand_in_additional_files_alone(tmp_path):
    text = '<x><n value="a.net.xml"/><a value="b.xml, c.xml"/></x>'
    found = read_sumo_configuration(written(tmp_path, text))
    assert (found.route_files, found.additional_files) == (
        (),
        (tmp_path / "b.xml", tmp_path / "c.xml"),
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (f"<x>{FILES}<begn value='3'/></x>", r"SUMO has no option 'begn'"),
        (f"<x>{FILES}<b value='3'/><begin value='3'/></x>", "begin is given twice"),
        (f"<x>{FILES}<load-state value='s.xml'/></x>", "load-state .* cannot be followed"),
        (f"<additional>{FILES}</additional>", "this is SUMO additional definitions"),
    ],
)
def test_what_cannot_be_followed_is_one_sentence(tmp_path, text, message):
    with pytest.raises(InputError, match=message):
        read_sumo_configuration(written(tmp_path, text))


def test_paths_are_relative_to_the_configuration(tmp_path):
    found = read_sumo_configuration(written(tmp_path, f"<x>{FILES}</x>"))
    assert found.net_file == Path(tmp_path, "a.net.xml")
