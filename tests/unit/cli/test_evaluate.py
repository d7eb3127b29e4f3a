"""``dmil evaluate``: whom differences are taken to, and the page."""

import csv
import json
import re

import pytest

from dmil.scenarios.names import find_resco_configuration

RUN = ("evaluate", "--scenario", "grid:1x1", "--steps", 120, "--seeds", 3, "--jobs", 1)


def test_the_reference_is_put_beside_and_subtracted(dmil):
    found = dmil.json(*RUN, "--reference", "random")
    controllers = {each["controller"]: each for each in found["controllers"]}
    assert "random" in controllers
    for each in controllers.values():
        minus = each["minus_random"]["delay_s"]["mean"]
        means = (one["measures"]["delay_s"]["mean"] for one in (each, controllers["random"]))
        assert minus == pytest.approx(next(means) - next(means))
    text = dmil(*RUN, "--reference", "random")
    assert "− random" in text
    assert "− max-pressure" not in text


def test_the_table_tells_delay_stops_and_what_was_overruled(dmil):
    text = dmil(*RUN)
    assert re.search(r"^delay +\d", text, re.MULTILINE)
    assert re.search(r"^stops +\d", text, re.MULTILINE)
    assert "overruled" not in text
    assert "CO2" not in text  # only SUMO knows it
    forbidden = dmil(*RUN, "--min-green", 25)
    assert re.search(r"^overruled +\d", forbidden, re.MULTILINE)


def test_a_long_name_of_the_reference_is_not_cut(dmil):
    text = dmil(*RUN, "--reference", "longest-queue-first")
    assert re.search(r"^− longest-queue- .*\nfirst ", text, re.MULTILINE)


def test_a_controller_with_options_in_one_word_stands_beside_the_plain_one(dmil):
    variant = "fixed-cycle,green_s=30"
    found = dmil.json(*RUN, "--controller", variant, "--reference", variant)
    controllers = {each["controller"]: each for each in found["controllers"]}
    assert {variant, "fixed-cycle", "max-pressure"} <= controllers.keys()
    delays = {name: each["per_seed"]["delay_s"] for name, each in controllers.items()}
    assert delays[variant] != delays["fixed-cycle"]
    assert controllers[variant][f"minus_{variant}"]["delay_s"]["mean"] == 0.0


def test_the_reference_may_be_one_with_options_that_is_not_judged(dmil):
    variant = "max-pressure,approaching=true"
    found = dmil.json(*RUN, "--reference", variant)
    assert variant in [each["controller"] for each in found["controllers"]]


@pytest.mark.parametrize(
    ("controller", "message"),
    [
        ("max-presure,approaching=true", "no controller named 'max-presure'"),
        ("max-pressure,aproaching=true", "Did you mean 'approaching'?"),
        ("max-pressure,approaching", "expected NAME or NAME,option=value"),
        ("sarsa,epsilon=2", "epsilon = 2; expected less than or equal to 1"),
    ],
)
@pytest.mark.parametrize("command", ["evaluate", "simulate"])
def test_what_is_wrong_with_a_variant_is_told(command, controller, message, dmil):
    dmil(command, "--scenario", "grid:1x1", "--controller", controller, code=2)
    assert message in " ".join(dmil.err.split())


def test_the_reference_must_be_known(dmil):
    dmil(*RUN, "--reference", "nobody", code=2)
    assert "--reference: found 'nobody'; expected one of fixed-cycle" in dmil.err


def test_the_page_has_answer_numbers_findings_and_picture(dmil, tmp_path):
    page = tmp_path / "report.html"
    found = dmil.json(*RUN, "--reference", "random", "--report", page)
    assert found["report"] == str(page)
    html = page.read_text(encoding="utf-8")
    assert "grid:1x1: controllers compared" in html
    for each in found["controllers"]:
        assert f'<td class="name">{each["controller"]}<' in html
        mean = each["measures"]["delay_s"]["mean"]
        assert f'<b class="n">{mean:.1f}</b>' in html
    verdicts = re.findall(r'<span class="verdict \w+">([^<]+)</span>', html)
    assert len(verdicts) == len(found["controllers"]) - 1
    assert "less" in verdicts
    picture = re.search(r'"network": (\{.*\}),\n', html)
    assert json.loads(picture[1])["datasets"]
    assert "The doctor found" in html


def test_one_seed_shows_nothing(dmil, tmp_path):
    page = tmp_path / "report.html"
    dmil(*RUN, "--seeds", 1, "--report", page)
    assert "one seed shows nothing" in page.read_text(encoding="utf-8")


def test_the_numbers_are_there_though_the_page_cannot_be_written(dmil, tmp_path):
    text = dmil(*RUN, "--report", tmp_path, code=2)
    assert re.search(r"^delay +\d", text, re.MULTILINE)
    assert str(tmp_path) in dmil.err.replace("\n", "")


def test_the_prefix_of_a_configuration_may_be_left_out(dmil):
    dmil("simulate", "--scenario", "missing.sumocfg", code=2)
    assert "missing.sumocfg: there is no such file" in dmil.err


def test_vehicles_without_a_way_are_told(dmil, tmp_path):
    pytest.importorskip("sumolib", reason="needs the extra sumo")
    path = find_resco_configuration("resco/cologne1")
    stray = tmp_path / "stray.rou.xml"
    stray.write_text('<routes><trip id="x" depart="25201" from="nowhere" to="else"/></routes>')
    routes = path.with_suffix(".rou.xml")
    files = ("--net", path.with_suffix(".net.xml"), "--begin", 25200, "--steps", 60)
    run = ("evaluate", *files, "--seeds", 1, "--jobs", 1)
    found = dmil.json(*run, "--routes", f"{routes},{stray}")
    assert any("cannot be simulated: 1 of the files' vehicles" in note for note in found["notes"])
    assert "cannot be simulated" not in dmil(*run, "--routes", routes)


def test_median_interquartile_mean_and_worst_seed_stand_below_every_mean(dmil, tmp_path):
    page, rows = tmp_path / "page.html", tmp_path / "seeds.csv"
    run = ("evaluate", "grid:1x2", "--steps", 300, "--seeds", 3, "--jobs", 1)
    text = dmil(*run, "--report", page, "--csv", rows)
    with rows.open(encoding="utf-8") as file:
        found = [each for each in csv.DictReader(file) if each["controller"] == "max-pressure"]
    delays = sorted(float(each["delay_s"]) for each in found)
    # Of three, a quarter is less than one: nobody is left out of the interquartile mean.
    mean = sum(delays) / 3
    told = [f"{each:.1f}" for each in (delays[1], mean, delays[2])]
    assert " ".join(told) in text
    assert " · ".join(told) in page.read_text(encoding="utf-8")
    assert text.count("median IQM worst") == 6
    assert "median IQM worst" not in dmil(*run[:5], 1)
