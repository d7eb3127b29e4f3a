"""A network of one's own: who is compared, what is answered, what locked, and other days."""

import csv
import re
from pathlib import Path

import pytest

CASE = Path(__file__).parents[2] / "cases" / "factored-stuck"
FILES = (CASE / "net.net.xml", CASE / "r.rou.xml")
APPROACHING = ("longest-queue-first,approaching=true", "max-pressure,approaching=true")
STUCK = "factored,guard=false"
"""Shows one phase for ever on lanes that straight and left share."""
RUN = ("evaluate", *FILES, "--steps", 900, "--jobs", 1)

pytestmark = pytest.mark.usefixtures("sumo_files")


@pytest.fixture
def sumo_files():
    pytest.importorskip("sumolib", reason="needs the extra sumo")


def by_name(found):
    return {each["controller"]: each for each in found["controllers"]}


def test_plan_rules_that_see_who_comes_and_memories_stand_side_by_side_sorted(dmil):
    found = dmil.json(*RUN, "--seeds", 1)
    names = [each["controller"] for each in found["controllers"]]
    assert set(names) == {"program", *APPROACHING, "combined", "factored", "lookahead"}
    delays = [each["measures"]["delay_s"]["mean"] for each in found["controllers"]]
    assert delays == sorted(delays)
    assert all("minus_program" in each for each in found["controllers"])


@pytest.mark.slow
def test_in_sumo_actuated_control_stands_beside_and_locks_are_named(dmil):
    pytest.importorskip("libsumo", reason="needs the extra sumo")
    run = (*RUN, "--seeds", 1, "--simulator", "sumo")
    found = by_name(dmil.json(*run))
    assert "actuated" in found
    assert not any(each["locked"] for each in found.values())
    found = by_name(dmil.json(*run, "--controller", STUCK))
    assert [each["junction"] for each in found[STUCK]["locked"]] == ["C"]
    assert found["program"]["locked"] == []


def test_where_lanes_are_shared_everybody_is_served_and_the_answer_beats_the_plan(dmil):
    run = (*RUN, "--seeds", 3, "--resample")
    found = by_name(dmil.json(*run))
    assert not any(each["locked"] for each in found.values())
    for name in (*APPROACHING, "combined", "factored", "lookahead"):
        assert found[name]["minus_program"]["delay_s"]["high"] < 0
    assert "Keep your plan" not in dmil(*run)


def test_locked_runs_are_named_with_median_iqm_and_worst_beside_the_mean(dmil, tmp_path):
    page, rows = tmp_path / "r.html", tmp_path / "seeds.csv"
    chosen = ("--no-baselines", "--controller", "program", "--controller", STUCK)
    run = (*RUN, *chosen, "--seeds", 2, "--resample", "--report", page, "--csv", rows)
    text = dmil(*run)
    assert text.splitlines()[2].startswith("Keep your plan: it has less delay")
    flat = " ".join(text.split())
    assert re.search(r"factored,guard=false: 2 of 2 seeds locked at junction C from \d+ s on", flat)
    assert re.search(r"^delay, s +mean +median +IQM +worst +− program", text, re.MULTILINE)
    html = page.read_text(encoding="utf-8")
    assert "factored,guard=false: 2 of 2 seeds locked at junction C" in html
    assert "<b>Keep your plan" in html
    assert "figure-ranking" in html
    with rows.open(encoding="utf-8", newline="") as file:
        values = list(csv.DictReader(file))
    assert len(values) == 2 * 2
    found = by_name(dmil.json(*run))
    for row in values:
        one = found[row["controller"]]
        assert float(row["delay_s"]) == one["per_seed"]["delay_s"][int(row["seed"])]
        assert bool(row["locked_junction"]) == bool(one["locked"])
    for one in found.values():
        delays = one["per_seed"]["delay_s"]
        measured = one["measures"]["delay_s"]
        assert measured["worst"] == max(delays)
        assert measured["median"] == pytest.approx(sum(delays) / 2)
        assert measured["interquartile_mean"] == pytest.approx(sum(delays) / 2)


def test_one_recorded_day_has_no_interval_and_resampled_days_have_one(dmil):
    run = (*RUN, "--seeds", 3, "--no-baselines", "--controller", "program")
    found = dmil.json(*run, "--controller", "fixed-cycle")
    assert found["same_demand"]
    for one in found["controllers"]:
        assert one["measures"]["delay_s"]["low"] is None
        assert one["minus_program"]["delay_s"]["high"] is None
    assert any("one day, no interval" in note for note in found["notes"])
    assert not re.search(r"\[[−\d]", dmil(*run, "--controller", "fixed-cycle"))
    days = dmil.json(*run, "--resample")
    (one,) = days["controllers"]
    assert not days["same_demand"]
    assert len(set(one["per_seed"]["delay_s"])) == 3
    assert one["measures"]["delay_s"]["low"] < one["measures"]["delay_s"]["high"]
    assert any("shifted by up to 60 s" in note for note in days["notes"])


def test_days_are_the_same_for_all_and_departures_may_stay(dmil):
    run = (*RUN, "--seeds", 2, "--no-baselines", "--resample-shift", 0)
    both = dmil.json(*run, "--controller", "program", "--controller", "fixed-cycle")
    spawned = [each["per_seed"]["spawned_veh"] for each in both["controllers"]]
    assert spawned[0] == spawned[1] == [266, 266]
    again = by_name(dmil.json(*run, "--controller", "program"))["program"]["per_seed"]
    assert again == by_name(both)["program"]["per_seed"]


@pytest.mark.slow
def test_resampled_days_drive_in_sumo_and_are_exported(dmil, tmp_path):
    pytest.importorskip("libsumo", reason="needs the extra sumo")
    run = ("simulate", *FILES, "--steps", 300, "--controller", "program", "--resample")
    queue, sumo = (
        dmil.json(*run, "--seed", 1, "--simulator", name)["runs"][0] for name in ("queue", "sumo")
    )
    assert queue["spawned_veh"] == sumo["spawned_veh"]
    one, other = (
        dmil.json(
            *("export", *FILES, "--steps", 300, "--controller", "fixed-cycle", "--resample"),
            *("--seed", seed, "--out", tmp_path / str(seed)),
        )["in_sumo"]["the network's program"]
        for seed in (1, 2)
    )
    assert one != other


def test_random_arrivals_are_not_resampled(dmil):
    dmil("simulate", "grid:1x1", "--resample", code=2)
    assert "vehicles arrive at random" in dmil.err
    assert "Leave --resample out." in dmil.err


def test_the_reference_may_learn_and_capitals_do_not_matter(dmil):
    run = ("evaluate", "Grid:1x1", "--steps", 120, "--seeds", 2, "--jobs", 1)
    found = dmil.json(*run, "--reference", "Factored", "--controller", "Fixed-Cycle")
    assert set(by_name(found)) == {
        *("fixed-cycle", "longest-queue-first", "max-pressure", "factored"),
    }
    for one in found["controllers"]:
        assert {"minus_factored", "minus_max-pressure"} <= one.keys()


def test_labels_show_what_set_changed(dmil):
    run = ("evaluate", "grid:1x1", "--steps", 120, "--seeds", 1, "--jobs", 1)
    found = by_name(dmil.json(*run, "--controller", "max-pressure", "--set", "approaching=true"))
    assert {"max-pressure,approaching=true", "max-pressure"} <= found.keys()


def test_policies_that_were_trained_elsewhere_are_named(dmil, tmp_path):
    paths = [tmp_path / name for name in ("a.npz", "b.npz")]
    for path, load in zip(paths, (1, 2), strict=True):
        dmil(
            *("train", "grid:1x1", "--steps", 60, "--episodes", 1, "--load", load),
            *("--out", path, "--no-compare"),
        )
    run = ("evaluate", "--policy", paths[0], "--policy", paths[1], "--seeds", 1, "--jobs", 1)
    notes = dmil.json(*run)["notes"]
    assert "Trained on something other than evaluated here: b.npz (differs in load)." in notes


def test_tables_fit_80_columns_and_break_no_word(dmil):
    text = dmil(*RUN, "--seeds", 2, "--resample", "--controller", "fixed-cycle,green_s=30")
    assert max(map(len, text.splitlines())) <= 80
    for word in ("longest-queue-first", "max-pressure", "approaching=true", "green_s=30"):
        assert word in text
    words = {"approaching", "throughput", "intersection", "lookahead", "factored"}
    for line in text.splitlines():
        for piece in re.findall(r"[a-z]{4,}$", line):
            assert not any(w.startswith(piece) and w != piece for w in words), line


def test_a_control_that_only_sumo_runs_is_the_reference_there(dmil):
    folder = Path(__file__).parents[2] / "cases" / "nema-program"
    files = ("--net", folder / "ne.net.xml", "--routes", folder / "ne.rou.xml")
    run = ("evaluate", *files, "--steps", 60, "--seeds", 1, "--jobs", 1)
    assert "fixed-cycle" in by_name(dmil.json(*run))
    in_sumo = by_name(dmil.json(*run, "--simulator", "sumo"))
    assert {"program", "actuated"} <= set(in_sumo)
    dmil(*run, "--controller", "program")
    said = " ".join(dmil.err.split())
    assert "Warning: intersection 'A0': its own control (NEMA) runs in SUMO only" in said
