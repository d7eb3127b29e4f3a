"""How far two simulators agree, against SciPy and by hand."""

import numpy as np
import polars as pl
import pytest
from scipy.stats import kendalltau

from dmil.seeding import stream
from dmil.studies.resco.agreement import agreement
from dmil.studies.resco.contenders import Judged, RescoContender


def study(sumo, **queues):
    """Make a study from (networks, contenders, seeds) delays of every simulator."""
    delays = np.stack([sumo, *queues.values()])
    names = tuple(f"c{number}" for number in range(delays.shape[2]))
    return Judged(
        axes={
            "simulator": ("sumo", *(name.replace("_", "-") for name in queues)),
            "scenario": [f"net{number}" for number in range(delays.shape[1])],
            "contender": [RescoContender(name) for name in names],
            "seed": range(delays.shape[3]),
        },
        names=names,
        trained_in=(),
        measures={"delay_s": delays, "travel_time_s": delays + 60},
    )


def rows(table, simulator, metric="delay_s"):
    chosen = table.filter((pl.col("metric") == metric) & (pl.col("simulator") == simulator))
    return {row["scenario"]: row for row in chosen.iter_rows(named=True)}


@pytest.mark.parametrize("contenders", [2, 3, 8, 12])
def test_tau_is_scipys(contenders):
    rng = stream(1, "delays", str(contenders))
    # Few whole numbers: there are ties in either simulator.
    sumo, queue = rng.integers(1, 6, (2, 5, contenders, 1)).repeat(3, axis=3).astype(float)
    found = rows(agreement(study(sumo, queue=queue)), "queue")
    for number in range(5):
        theirs = kendalltau(sumo[number, :, 0], queue[number, :, 0]).statistic
        ours = found[f"net{number}"]["tau"]
        assert (ours is None and np.isnan(theirs)) or ours == pytest.approx(theirs)


def test_equal_ranks_are_one_and_reversed_ones_minus_one():
    sumo = np.array([[[10.0] * 2, [20.0] * 2, [30.0] * 2]])
    found = agreement(study(sumo, queue=2 * sumo, queue_calibrated=1 / sumo))
    assert rows(found, "queue")["net0"]["tau"] == 1.0
    row = rows(found, "queue-calibrated")["net0"]
    assert row["tau"] == -1.0 and row["gain"] == -2.0


def test_the_pooled_tau_counts_pairs_within_networks_only():
    # Within each network the ranks are reversed; across networks they agree.
    sumo = np.array([[[1.0], [2.0]], [[100.0], [200.0]]])
    queue = sumo[:, ::-1]
    pooled = rows(agreement(study(sumo, queue=queue)), "queue")[None]
    assert pooled["tau"] == -1.0 and (pooled["pairs"], pooled["contenders"]) == (2, 4)


def test_networks_weigh_by_their_pairs():
    agreeing = np.arange(1.0, 5.0)[:, None]
    reversed_pair = np.array([1.0, 2.0, np.nan, np.nan])[:, None]
    sumo = np.stack([agreeing, reversed_pair])
    queue = np.stack([agreeing, np.array([2.0, 1.0, np.nan, np.nan])[:, None]])
    pooled = rows(agreement(study(sumo, queue=queue)), "queue")[None]
    assert pooled["tau"] == pytest.approx((6 - 1) / 7)


def test_controllers_of_one_simulator_only_are_left_out():
    sumo = np.arange(1.0, 5.0)[None, :, None]
    queue = sumo.copy()
    queue[0, 1] = np.nan
    row = rows(agreement(study(sumo, queue=queue)), "queue")["net0"]
    assert (row["contenders"], row["pairs"], row["tau"]) == (3, 3, 1.0)


def test_differences_are_medians_over_controllers():
    sumo = np.array([[[10.0] * 3, [20.0] * 3, [40.0] * 3]])
    queue = sumo * np.array([0.5, 0.8, 1.6])[:, None]
    row = rows(agreement(study(sumo, queue=queue)), "queue")["net0"]
    assert row["difference"] == pytest.approx(-0.2) and row["distance"] == pytest.approx(0.5)
    assert row["difference_low"] == row["difference_high"] == pytest.approx(-0.2)
    travel = rows(agreement(study(sumo, queue=queue)), "queue", "travel_time_s")["net0"]
    assert travel["difference"] == pytest.approx(np.median([65 / 70, 76 / 80, 124 / 100]) - 1)


def test_pairs_that_sumo_does_not_tell_apart_do_not_count_as_clear():
    rng = stream(1, "noise")
    level = np.array([10.0, 10.0, 30.0])[None, :, None]
    sumo = level + rng.normal(0, 1, (1, 3, 8))
    queue = np.broadcast_to(np.array([11.0, 10.0, 30.0])[None, :, None], sumo.shape)
    swapped = sumo.mean(axis=2)[0, 0] < sumo.mean(axis=2)[0, 1]
    row = rows(agreement(study(sumo, queue=queue)), "queue")["net0"]
    assert (row["pairs"], row["clear_pairs"], row["clear_tau"]) == (3, 2, 1.0)
    assert row["tau"] == pytest.approx(1 / 3 if swapped else 1.0)


def test_the_interval_holds_tau_of_noisy_ranks():
    rng = stream(4, "noise")
    level = np.linspace(10, 20, 8)[None, :, None]
    sumo, queue = (level + rng.normal(0, 3, (1, 8, 6)) for _ in range(2))
    row = rows(agreement(study(sumo, queue=queue)), "queue")["net0"]
    assert row["tau_low"] <= row["tau"] <= row["tau_high"]
    assert 0.05 < row["tau_high"] - row["tau_low"] < 1.5


def test_missing_seeds_do_not_break_a_resample():
    sumo = np.array([[[10.0, 11.0], [20.0, np.nan], [30.0, 31.0]]])
    row = rows(agreement(study(sumo, queue=2 * sumo)), "queue")["net0"]
    assert row["tau"] == row["tau_low"] == row["tau_high"] == 1.0


@pytest.mark.parametrize("simulators", [("sumo",), ("queue", "queue-calibrated")])
def test_it_takes_both_kinds_of_simulator(simulators):
    values = np.ones((len(simulators), 1, 2, 2))
    made = Judged(
        axes={
            "simulator": simulators,
            "scenario": ["net"],
            "contender": [RescoContender("a"), RescoContender("b")],
            "seed": (0, 1),
        },
        names=("a", "b"),
        trained_in=(),
        measures={"delay_s": values, "travel_time_s": values},
    )
    found = agreement(made)
    assert found.is_empty() and "tau" in found.columns
