"""The study of protocols: its recipes, its days, its tables on made-up runs, and one run."""

import json

import numpy as np
import polars as pl
import pytest

from dmil.controllers import CONTROLLERS
from dmil.errors import InputError
from dmil.results import TABLES
from dmil.results.metrics import METRICS
from dmil.simulation.cityflow.process import has_cityflow
from dmil.studies.protocols import ProtocolsStudySettings
from dmil.studies.protocols.plan import build, day, trials
from dmil.studies.protocols.published import COUNTERPART, PUBLISHED
from dmil.studies.protocols.recipes import CITIES, LLMLIGHT, PROTOCOLS
from dmil.studies.protocols.rule import NAME
from dmil.studies.protocols.study import run_trial
from dmil.studies.protocols.tables import METHOD, RULE, tables_of_runs
from tests.unit.cityflow.conftest import crossing_document


@pytest.fixture
def settings(tmp_path):
    """A crossing that stands in for one city's day."""
    name, flow = CITIES["JN1"]
    folder = tmp_path / name
    folder.mkdir()
    keys = ("length", "width", "maxPosAcc", "maxNegAcc", "usualPosAcc", "usualNegAcc", "minGap")
    vehicle = dict(zip(keys, (5.0, 2.0, 2.0, 4.5, 2.0, 4.5, 2.5), strict=True))
    vehicle |= {"maxSpeed": 11.111, "headwayTime": 2}
    flows = [
        {
            "vehicle": vehicle,
            "route": [f"{a}_in", f"{b}_out"],
            "interval": 6,
            "startTime": k,
            "endTime": 150,
        }
        for k, (a, b) in enumerate((("E", "W"), ("N", "S")))
    ]
    (folder / "roadnet.json").write_text(json.dumps(crossing_document()[0]))
    (folder / flow).write_text(json.dumps(flows))
    return ProtocolsStudySettings(
        protocols=(LLMLIGHT,),
        controllers=(NAME, "max-pressure"),
        data=tmp_path,
        seeds=2,
        horizon_s=240,
    )


def rows(protocol, simulator, controller, at_lanes, trip, horizon_s=3600):
    """Make up three days of a controller, the recorded one first."""
    keys = {"preset": protocol, "scenario": "JN1", "simulator": simulator, "status": "ok"}
    return [
        dict.fromkeys(TABLES["runs"].schema)
        | keys
        | {"controller": controller, "seed": seed, "travel_time_s": trip + seed}
        | {"horizon_s": horizon_s}
        | {"last_minus_first_s": None if at_lanes is None else at_lanes + seed}
        for seed in range(3)
    ]


@pytest.fixture
def tables():
    made = rows(LLMLIGHT, "cityflow", RULE, 280.0, 330.0)
    made += rows(LLMLIGHT, "cityflow", METHOD, 270.0, 320.0)
    made += rows("coordlight-5-2", "cityflow", RULE, 210.0, 250.0)
    made += rows(LLMLIGHT, "queue", METHOD, None, 288.0)
    return tables_of_runs(pl.DataFrame(made, schema=TABLES["runs"].schema))


def test_no_published_figure_stands_beside_a_shorter_run():
    for horizon_s, compares in ((3600, True), (300, False)):
        made = rows(LLMLIGHT, "cityflow", RULE, 280.0, 330.0, horizon_s)
        tables = tables_of_runs(pl.DataFrame(made, schema=TABLES["runs"].schema))
        assert tables.published.is_empty() != compares
        assert tables.ours["same_recipe"].to_list() == [compares]


def test_figures_stand_beside_reproduced_protocols_only():
    reproduced = {name for name, each in PROTOCOLS.items() if each.standing == "reproduced"}
    assert {protocol for protocol, _ in PUBLISHED} == reproduced == {LLMLIGHT}
    assert all(set(figures) == set(CITIES) for figures in PUBLISHED.values())
    assert set(COUNTERPART) <= {method for _, method in PUBLISHED}


def test_every_measure_is_a_metric_and_the_rule_is_no_controller_of_the_catalogue():
    assert {each.measure for each in PROTOCOLS.values()} <= set(METRICS)
    assert NAME not in CONTROLLERS
    assert METHOD in CONTROLLERS


def test_without_cityflow_all_run_in_the_queue_simulator(settings):
    alone = trials(settings, cityflow=False)
    assert {(each.simulator, each.controller.name) for each in alone} == {("queue", "max-pressure")}
    both = trials(settings, cityflow=True)
    assert {each.controller.name for each in both if each.simulator == "cityflow"} == {
        NAME,
        "max-pressure",
    }


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"protocols": ("llmlight",)}, "llmlight"),
        ({"cities": ("JN9",)}, "JN9"),
        ({"cities": ("HZ1",)}, "there is no file"),
        ({"controllers": (NAME,)}, "no controller can run"),
    ],
)
def test_bad_settings_end_with_one_error(settings, change, said):
    with pytest.raises(InputError, match=said):
        trials(settings.model_copy(update=change), cityflow=False)


def test_a_recipe_takes_the_first_phases_and_days_differ_in_departures_alone(settings):
    made = build(settings, PROTOCOLS[LLMLIGHT], "JN1")
    assert [len(item.phases) for item in made.network.intersections] == [4]
    assert (made.timing.decision_interval_s, made.timing.clearance_s) == (30, 5)
    recorded, other = (day(made, seed, 30) for seed in (0, 1))
    assert len(recorded) == len(other)
    assert (np.diff(other.depart_s) >= 0).all()
    assert (recorded.depart_s != other.depart_s).any()
    assert np.array_equal(other.depart_s, day(made, 1, 30).depart_s)


def test_recorded_day_and_mean_of_others(tables):
    row = tables.ours.row(0, named=True)
    assert (row["recorded_s"], row["mean_s"], row["days"]) == (280.0, 281.5, 2)
    assert 281 <= row["low_s"] <= 281.5 <= row["high_s"] <= 282
    queue = tables.ours.filter(simulator="queue").row(0, named=True)
    assert (queue["measure"], queue["same_recipe"]) == ("travel_time_s", False)


def test_published_figures_have_ours_of_the_same_rule_beside_them(tables):
    ours = dict(tables.published.select("method", "ours_s").rows())
    assert ours.pop("max-pressure") == 280.0
    assert set(ours.values()) == {None}
    assert set(tables.published["scenario"]) == {"JN1"}
    assert set(tables.published["preset"]) == {LLMLIGHT}


def test_a_split_changes_one_thing_at_a_time(tables):
    assert tables.split.rows() == [
        (LLMLIGHT, "JN1", -10.0, 0.0, -50.0),
        ("coordlight-5-2", "JN1", None, -70.0, -40.0),
    ]


def test_the_queue_simulator_is_compared_by_the_whole_trip(tables):
    row = tables.agreement.row(0, named=True)
    assert row["controllers"] == 1
    assert row["error_pct"] == pytest.approx(100 * (289 / 321 - 1))
    assert row["tau"] is None


@pytest.mark.parametrize(
    "simulator",
    [
        "queue",
        pytest.param(
            "cityflow",
            marks=pytest.mark.skipif(
                not has_cityflow(),
                reason="the module cityflow is not installed (built from its repository)",
            ),
        ),
    ],
)
def test_runs_measure_what_their_simulator_knows(settings, simulator):
    wanted = [each for each in trials(settings, cityflow=True) if each.simulator == simulator]
    for each in wanted:
        row = run_trial(settings, each).runs[0]
        assert row["status"] == "ok"
        assert row["travel_time_s"] > 0
        if simulator == "queue":
            assert row["last_minus_first_s"] is None
        else:
            assert 0 < row["entering_lanes_s"] <= row["last_minus_first_s"] + 1
