"""Tables of the study on the RESCO benchmark, from a made-up one with known answers."""

import numpy as np
import polars as pl
import pytest

from dmil.errors import InputError
from dmil.results import Results
from dmil.scenarios.names import RESCO
from dmil.studies.resco.contenders import RescoContender, contender_names, judged
from dmil.studies.resco.published import METHODS, PUBLISHED, published_by
from dmil.studies.resco.tables import (
    best_published_learner,
    learning_curves,
    queue_courses,
    resco_tables,
    scores,
)
from tests.unit.made_up_resco import (
    CALIBRATED,
    CONTENDERS,
    DELAY_S,
    QUEUE,
    SCENARIOS,
    SIMULATORS,
    SUMO,
    UNBLOCKED,
    expected_delay,
)

LEARNERS = ("IDQN", "IPPO", "MPLight", "FMA2C")
PROGRAM = ("program", None, False)
BEST = ("dual-memory", "cells", True)


@pytest.fixture(scope="module")
def results(make_resco_study):
    with Results(make_resco_study()) as opened:
        yield opened


@pytest.fixture(scope="module")
def tables(results):
    return resco_tables(results)


def row_of(table, **values):
    return table.filter(*(pl.col(n).eq_missing(v) for n, v in values.items())).row(0, named=True)


def test_runs_are_arranged_by_simulator_network_contender_and_seed(results):
    runs = judged(results)
    assert runs.judge == SUMO and runs.simulators == [SUMO, CALIBRATED, QUEUE]
    # Real towns first, small networks before large ones.
    assert [name.removeprefix("resco/") for name in runs.scenarios] == [
        "cologne1",
        "ingolstadt21",
        "arterial4x4",
        "grid4x4",
    ]
    assert len(runs.contenders) == len(CONTENDERS) and runs.names[0] == "program"
    assert runs.of("delay_s", simulator=SUMO).shape == (4, 12, 5)
    actuated = runs.number("contender", RescoContender("actuated"))
    assert np.isnan(runs.of("delay_s", simulator=QUEUE)[:, actuated]).all()
    assert not np.isnan(runs.of("delay_s", simulator=SUMO)).any()
    frame = results.runs().filter(
        (pl.col("scenario") == runs.scenarios[1])
        & (pl.col("simulator") == QUEUE)
        & (pl.col("controller") == "random")
    )
    ours = runs.of("delay_s", simulator=QUEUE)[
        1, runs.number("contender", RescoContender("random"))
    ]
    assert ours.tolist() == frame.sort("seed")["delay_s"].to_list()


def test_names_say_only_what_differs():
    sarsa = RescoContender("sarsa", "exact", False, "queue", 0.1)
    assert contender_names([sarsa, RescoContender("random")]) == ["sarsa exact", "random"]
    other = RescoContender("sarsa", "exact", True, "pressure", 0.2)
    assert contender_names([sarsa, other]) == [
        "sarsa exact queue reward ε 0.1",
        "sarsa exact + communication pressure reward ε 0.2",
    ]


@pytest.mark.parametrize("contender", CONTENDERS)
def test_intervals_of_the_delay_hold_what_was_put_in(tables, contender):
    controller, embedding, communication = contender
    for place, scenario in enumerate(SCENARIOS):
        row = row_of(
            tables.headline,
            scenario=scenario,
            controller=controller,
            embedding=embedding,
            communication=communication,
        )
        assert row["n"] == 5 and row["low"] < row["mean"] < row["high"]
        assert row["iqm_low"] < row["iqm"] < row["iqm_high"]
        assert row["mean"] == pytest.approx(expected_delay(contender, SUMO, place), rel=0.15)


def test_the_difference_to_max_pressure_is_paired(tables):
    row = row_of(tables.headline, scenario=SCENARIOS[0], controller="longest-queue-first")
    unpaired = row["high"] - row["low"]
    assert row["difference"] == pytest.approx(-10, abs=1.5)
    assert row["difference_low"] < row["difference"] < row["difference_high"] < 0
    # What seeds share cancels: the interval is much shorter than that of the mean.
    assert row["difference_high"] - row["difference_low"] < 0.6 * unpaired
    assert row["share_better"] == 1.0
    assert row_of(tables.headline, controller="random")["share_better"] == 0.0
    assert row_of(tables.headline, controller="max-pressure")["share_better"] is None


def test_among_the_best_are_those_not_shown_to_be_worse(tables):
    for scenario in SCENARIOS:
        chosen = tables.headline.filter("among_best", pl.col("scenario") == scenario)
        assert row_of(chosen, embedding="cells", communication=True)["among_best"]
        assert set(chosen["embedding"]) <= {"cells", "simple"}


def test_throughput_is_better_when_higher(tables):
    throughput = tables.scores.filter(
        (pl.col("metric") == "throughput_veh_per_h") & (pl.col("simulator") == SUMO)
    )
    assert (throughput["worst"] < throughput["median"]).all()
    best = throughput.filter("among_best")
    assert set(best["embedding"]) <= {"cells", "simple"}
    assert row_of(throughput, controller="random")["share_better"] == 0.0
    assert row_of(throughput, controller="longest-queue-first")["share_better"] == 1.0


def test_what_a_simulator_does_not_know_is_not_there(tables):
    emissions = tables.scores.filter(pl.col("metric") == "co2_g")
    assert set(emissions["simulator"]) == {SUMO}
    neutral = tables.scores.filter(pl.col("metric").is_in(["overruled", "bytes_total"]))
    assert neutral["among_best"].null_count() == neutral.height > 0


def test_published_numbers_stand_beside_their_counterparts(tables):
    row = row_of(tables.headline, scenario="resco/cologne1", controller="program")
    assert (row["published_method"], row["published_s"]) == ("fixed", 56.6)
    row = row_of(tables.headline, scenario="resco/arterial4x4", controller="max-pressure")
    assert (row["published_method"], row["published_s"]) == ("max-pressure", 952.7)
    # Greedy counts moving vehicles: it is not longest queue first.
    row = row_of(tables.headline, scenario="resco/cologne1", controller="longest-queue-first")
    assert row["published_method"] is None
    # Nothing was published for fixed time on the grids.
    for scenario in ("resco/grid4x4", "resco/arterial4x4"):
        row = row_of(tables.headline, scenario=scenario, controller="program")
        assert row["published_s"] is None
    assert row_of(tables.headline, embedding="cells")["published_s"] is None


def test_published_numbers_are_of_scenarios_that_exist():
    assert {value.scenario for value in PUBLISHED} <= set(RESCO)
    assert {value.method for value in PUBLISHED} == set(METHODS)
    for value in PUBLISHED:
        assert (value.last_s is not None) == (value.method in LEARNERS)
        assert value.last_s is None or value.last_s >= value.best_s
    assert "MPLight" not in published_by("resco/ingolstadt1")
    assert best_published_learner("resco/ingolstadt1") == ("IPPO", 20.9)
    assert best_published_learner("resco/arterial4x4") == ("FMA2C", 654.1)


def test_runs_that_lock_are_counted_in_both_protocols(make_resco_study):
    folder = make_resco_study(
        scenarios=SCENARIOS[:1],
        seeds=20,
        contenders=[("max-pressure", None, False), ("random", None, False)],
        simulators=(SUMO, UNBLOCKED, QUEUE),
    )
    with Results(folder) as opened:
        found = resco_tables(opened).locks
    assert found.height == 4 and set(found["simulator"]) == {SUMO, UNBLOCKED}
    row = row_of(found, simulator=SUMO, contender="random")
    assert (row["n"], row["locked"], row["from_s"]) == (20, 1, 1200.0)
    # Wilson's interval of 1 of 20, and of 0 of 20: none was seen, and that is not none.
    assert (row["low"], row["high"]) == pytest.approx((0.00888, 0.23613), abs=1e-4)
    for simulator, contender in ((UNBLOCKED, "random"), (SUMO, "max-pressure")):
        row = row_of(found, simulator=simulator, contender=contender)
        assert (row["locked"], row["low"], row["from_s"]) == (0, 0.0, None)
        assert row["high"] == pytest.approx(0.16113, abs=1e-4)


def test_one_locked_run_moves_the_mean_and_not_the_middle(make_resco_study):
    folder = make_resco_study(scenarios=SCENARIOS[:1], seeds=9, contenders=(PROGRAM,))
    with Results(folder) as opened:
        runs = judged(opened)
        before = scores(runs)
        runs.measures["delay_s"][0, 0, 0, 0] = 2_000.0
        after = scores(runs)
    chosen = {"metric": "delay_s", "simulator": SUMO}
    before, after = row_of(before, **chosen), row_of(after, **chosen)
    assert after["mean"] > before["mean"] + 150 and after["worst"] == 2_000.0
    assert after["iqm"] == pytest.approx(before["iqm"], rel=0.1)
    assert after["median"] == pytest.approx(before["median"], rel=0.1)


def test_overall_is_the_ratio_to_max_pressure_over_all_networks(tables):
    row = row_of(tables.overall, simulator=SUMO, contender="dual-memory cells + communication")
    assert (row["scenarios"], row["n"]) == (4, 20)
    assert row["low"] < row["ratio"] < row["high"] < 1
    assert row["ratio"] == pytest.approx(DELAY_S[BEST] / 40, rel=0.03)
    assert (row["share_better"], row["share_low"], row["share_high"]) == (1.0, 1.0, 1.0)
    itself = row_of(tables.overall, simulator=SUMO, contender="max-pressure")
    assert itself["ratio"] == 1.0 and itself["share_better"] is None


def test_best_episode_and_last_ten_of_the_training(tables, results):
    row = row_of(tables.training, scenario=SCENARIOS[0], contender="sarsa exact")
    # Delay falls from episode to episode; seeds differ by 0 to 4 s.
    assert (row["n"], row["episodes"], row["best_episode"]) == (5, 20, 19)
    assert row["best"] == pytest.approx(50 * (1 + 2 / 20) + 2)
    last = np.mean([50 * (1 + 2 / (1 + episode)) for episode in range(10, 20)]) + 2
    assert row["last"] == pytest.approx(last)
    assert row["last_low"] < last < row["last_high"] and row["trained_in"] == CALIBRATED
    assert tables.training.height == 7 * len(SCENARIOS)
    curves = learning_curves(results, tables.judged, SCENARIOS[0])
    assert curves.height == 7 * 20 and set(curves["scenario"]) == {SCENARIOS[0]}
    one = curves.filter(pl.col("contender") == "sarsa exact").sort("episode")
    assert one["mean"].to_list() == sorted(one["mean"], reverse=True)
    assert one["entries"].to_list() == [50.0 + 20 * episode for episode in range(20)]


def test_queues_are_means_of_minutes_in_sumo(tables, results):
    courses = queue_courses(results, tables.judged, SCENARIOS[0])
    one = courses.filter(pl.col("contender") == "max-pressure")
    assert one["time_s"].to_list() == [30.0 + 60 * minute for minute in range(61)]
    mean = row_of(tables.headline, scenario=SCENARIOS[0], controller="max-pressure")["mean"]
    assert one["mean"].max() == pytest.approx(2 * mean, rel=0.02)
    assert (one["low"] <= one["mean"]).all() and (one["mean"] <= one["high"]).all()


def test_the_interquartile_mean_leaves_out_a_quarter_at_either_end(make_resco_study):
    with Results(make_resco_study(scenarios=SCENARIOS[:1], seeds=8)) as opened:
        row = resco_tables(opened).headline.row(0, named=True)
        delays = np.sort(judged(opened).of("delay_s", simulator=SUMO)[0, 0])
    assert row["iqm"] == pytest.approx(delays[2:6].mean())
    assert row["median"] == pytest.approx(delays[3:5].mean())


def test_one_seed_has_means_and_nothing_else(make_resco_study):
    with Results(make_resco_study(seeds=1)) as opened:
        made = resco_tables(opened)
    assert made.headline["mean"].null_count() == 0
    assert made.headline["low"].null_count() == made.headline.height
    assert made.headline["among_best"].null_count() == made.headline.height
    assert made.agreement["tau"].null_count() == 0
    assert made.agreement["tau_low"].null_count() == made.agreement.height


def test_failed_runs_are_left_out(make_resco_study):
    folder = make_resco_study(scenarios=SCENARIOS[:1], failed={("max-pressure", SUMO)})
    with Results(folder) as opened:
        made = resco_tables(opened)
    assert "max-pressure" not in set(made.headline["controller"])
    assert made.headline["difference"].null_count() == made.headline.height
    assert set(made.overall["simulator"]) == {CALIBRATED, QUEUE}
    # It is still ranked among those that ran in both simulators: the others.
    assert set(made.agreement["contenders"]) == {10}


def test_a_study_without_a_success_is_said_so(make_resco_study):
    folder = make_resco_study(
        scenarios=SCENARIOS[:1], contenders=(PROGRAM,), failed={("program", s) for s in SIMULATORS}
    )
    with Results(folder) as opened, pytest.raises(InputError, match="SUMO died"):
        resco_tables(opened)
