import polars as pl
import pytest

from dmil.analysis.claims import Evidence, judge
from dmil.results import Results
from dmil.studies.paper.cells import CellComparison
from dmil.studies.paper.claims import claims, verdict_of
from dmil.studies.paper.statements import STATEMENTS


def judged(folder):
    with Results(folder) as results:
        table = claims(results)
    return {row["id"]: row for row in table.iter_rows(named=True)}


def test_verdicts_of_the_made_up_study(make_study):
    found = judged(make_study())
    holds = {name: row["holds"] for name, row in found.items()}
    assert holds == {
        "reward-effect": True,
        # Under "matched", No Memory is on the simple classes: Simple cannot beat it.
        "memory-beats-sarsa": False,
        # The two are the same but for chance.
        "simple-wins-default": None,
        "complex-loses-default": True,
        "single-intersection": True,
        "complex-gains-most": True,
        "rewards-alike": True,
        # Half of W/V_c is gone: more than "up to 30 %".
        "waiting-30": False,
        "throughput-100": False,
        "classes-infer": None,
        "throughput-improved": None,
        "communication-raises-default": None,
        # In the longer runs of this study communication helps.
        "communication-no-gain-default": None,
        "communication-neutral": True,
        "memory-flatter": True,
        "memory-smaller": None,
        "similar-metrics": None,
        "split-smaller": True,
        "communication-smaller": None,
        "simple-smaller": None,
        "tiny-decrease": None,
        "little-expense": None,
        "baselines-win": True,
        "classes-carry-the-gain": True,
        "two-memories-neutral": True,
    }
    assert set(found) == {statement.name for statement in STATEMENTS}
    verdicts = {name: row["verdict"] for name, row in found.items()}
    assert verdicts["memory-beats-sarsa"] == (
        "shown in 4 of 8 under entropy and diffusion; no under default"
    )
    assert verdicts["communication-smaller"] == "no per agent; yes counted once"
    assert verdicts["waiting-30"] == "no in W/V_c; no in W alone (shown in 12, refuted in 12 of 24)"
    outcomes = {row["outcome"] for row in found.values() if row["holds"] is None}
    assert outcomes == {"depends", "not shown"}
    assert {row["source"] for row in found.values()} == {"quotation", "table", "ours"}


def outcome_of(lows_and_highs, quantifier, relation="above", threshold=1.0):
    """Judge made-up intervals."""
    comparison = CellComparison("made up", "grid:5x5", "arrived_veh", 0, 1)
    evidence = [
        Evidence(comparison, (low + high) / 2, low, high, 30, judge(relation, threshold, low, high))
        for low, high in lows_and_highs
    ]
    return verdict_of(evidence, quantifier)


REFUTES, OPEN, SHOWS = (0.2, 0.3), (0.6, 1.1), (1.1, 1.4)


@pytest.mark.parametrize(
    ("quantifier", "intervals", "expected"),
    [
        # "Some does" is refuted only where all are.
        ("any", [REFUTES] * 12 + [OPEN] * 4, (None, "not shown")),
        ("any", [REFUTES, OPEN, SHOWS], (True, "holds")),
        ("any", [REFUTES] * 3, (False, "does not hold")),
        ("any", [OPEN], (None, "not shown")),
        # "All do" is refuted by one.
        ("all", [SHOWS, SHOWS], (True, "holds")),
        ("all", [SHOWS, OPEN], (None, "shown in 1 of 2")),
        ("all", [OPEN, OPEN], (None, "not shown")),
        ("all", [SHOWS, OPEN, REFUTES], (False, "shown in 1, refuted in 1 of 3")),
        ("all", [OPEN, REFUTES], (False, "does not hold")),
        ("all", [], (None, "not run")),
    ],
)
def test_what_is_open_neither_holds_nor_fails(quantifier, intervals, expected):
    assert outcome_of(intervals, quantifier) == expected


TWO_GRIDS = ("grid:1x1", "grid:3x3")


@pytest.fixture(scope="module")
def before(make_study):
    return judged(make_study(scenarios=TWO_GRIDS))


OPEN_BEFORE = {
    "communication-raises-default",
    "communication-no-gain-default",
    "communication-smaller",
    "memory-smaller",
}
OPEN_AFTER = {"memory-flatter", "communication-neutral", "two-memories-neutral"}


def scale(measure, factor, **which):
    """Return an adjustment that scales one mean of the cells that match."""

    def adjust(cell, scenario, means):
        if all(cell[key] == value for key, value in which.items()):
            means[measure] *= factor

    return adjust


# Adjustments of one study are of other measures or other rewards, so none touches another's claim.
FLIPS = (
    {
        "complex-loses-default": (
            scale("wait", 0.2, reward="default", embedding="complex"),
            False,
        ),
        "communication-neutral": (scale("wait", 1.2, reward="entropy", communication=True), False),
        "rewards-alike": (scale("arrived", 0.9, reward="entropy"), False),
        "memory-flatter": (scale("slope", 10, embedding="complex"), False),
    },
    {
        "communication-raises-default": (
            scale("wait", 1.2, reward="default", communication=True),
            True,
        ),
        "two-memories-neutral": (
            scale("wait", 0.8, controller="dual-memory", reward="entropy"),
            False,
        ),
        "throughput-100": (scale("arrived", 0.3, reward="default"), True),
        "memory-smaller": (scale("start", 10, controller="dual-memory"), False),
    },
    {
        "communication-no-gain-default": (
            scale("wait", 0.8, reward="default", communication=True),
            False,
        ),
        "baselines-win": (scale("wait", 0.1, controller="dual-memory", reward="entropy"), False),
        "communication-smaller": (
            scale("start", 0.5, controller="dual-memory", communication=True),
            True,
        ),
    },
    {"reward-effect": (scale("wait", 5, reward="entropy"), False)},
    {"single-intersection": (scale("wait", 0.3, controller="dual-memory"), False)},
    {"waiting-30": (scale("wait", 0.3, reward="default"), True)},
    {"classes-carry-the-gain": (scale("wait", 0.5, embedding="exact"), False)},
)


@pytest.mark.parametrize("flips", FLIPS, ids=" ".join)
def test_a_verdict_flips_when_the_data_flips(make_study, before, flips):
    def adjust(cell, scenario, means):
        for change, _ in flips.values():
            change(cell, scenario, means)

    after = judged(make_study(adjust=adjust, scenarios=TWO_GRIDS))
    for claim, (_, expected) in flips.items():
        # Some are open, or depend on the reading or the reward, on one side.
        earlier = None if claim in OPEN_BEFORE else not expected
        later = None if claim in OPEN_AFTER else expected
        assert before[claim]["holds"] != after[claim]["holds"], claim
        assert (before[claim]["holds"], after[claim]["holds"]) == (earlier, later), claim


def test_an_agent_whose_memory_grows_faster_is_not_flatter(make_study):
    adjust = scale("slope", 10, controller="dual-memory", embedding="complex")
    found = judged(make_study(adjust=adjust, scenarios=TWO_GRIDS))["memory-flatter"]
    assert "no m_s + m_L against exact SARSA" in found["verdict"]
    assert "no m_s + m_L against No Memory" in found["verdict"]


def test_agents_that_act_alike_put_nothing_to_the_test(make_study):
    folder = make_study(scenarios=("grid:3x3",))
    runs = pl.read_parquet(folder / "runs.parquet")
    # With communication all runs but one are those without.
    dual = runs.filter(pl.col("controller") == "dual-memory", pl.col("variant").is_null())
    key = ["scenario", "embedding", "reward", "seed"]
    alone = dual.filter(~pl.col("communication")).select(*key, "w_over_vc", "arrived_veh")
    runs = runs.join(alone, on=key, how="left", suffix="_alone", maintain_order="left")
    same = (
        pl.col("communication")
        & (pl.col("controller") == "dual-memory")
        & pl.col("variant").is_null()
        & ((pl.col("seed") > 0) | (pl.col("reward") == "diffusion"))
    )
    runs = runs.with_columns(
        w_over_vc=pl.when(same).then("w_over_vc_alone").otherwise("w_over_vc")
    ).drop("w_over_vc_alone", "arrived_veh_alone")
    runs.write_parquet(folder / "runs.parquet")
    found = judged(folder)
    # One seed of eight differs: put to the test. Under entropy and diffusion one of sixteen.
    assert found["communication-raises-default"]["verdict"] == "not shown"
    assert found["communication-neutral"]["verdict"] == (
        "not put to the test in short runs; yes in longer runs"
    )
    assert found["communication-neutral"]["holds"] is True


def test_under_literal_no_memory_is_exact_sarsa(make_study):
    found = judged(make_study(presets=("literal",)))
    assert found["memory-beats-sarsa"]["verdict"] == (
        "yes under entropy and diffusion; no under default (shown in 2, refuted in 2 of 4)"
    )
    assert found["simple-wins-default"]["holds"] is True
    # Against No Memory is against exact SARSA: asked once.
    assert {each["question"] for each in found["memory-flatter"]["evidence"]} == {
        "m_L against exact SARSA",
        "m_s + m_L against exact SARSA",
    }


def test_the_evidence_has_the_numbers(make_study):
    row = judged(make_study(scenarios=("grid:5x5",)))["complex-loses-default"]
    (evidence,) = row["evidence"]
    # Complex waits 0.2 · 0.7 · 2, SARSA on the simple classes 0.2 · 0.8.
    assert evidence["difference_pct"] == pytest.approx(75, abs=4)
    assert evidence["low_pct"] < evidence["difference_pct"] < evidence["high_pct"]
    assert evidence["n"] == 8 and evidence["scenario"] == "grid:5x5"
    assert row["summary"].startswith("5×5, default: Complex against No Memory: +")


def test_claims_without_their_runs_are_not_judged(make_study):
    only = [c for c in make_study.cells() if c["reward"] in ("entropy", None)]
    found = judged(make_study(cells=only, scenarios=("grid:3x3",)))
    assert found["reward-effect"]["holds"] is None
    assert found["reward-effect"]["verdict"] == "not run"
    assert found["single-intersection"]["holds"] is None
    assert found["baselines-win"]["holds"] is True


@pytest.mark.parametrize("seeds", [1, 4])
def test_few_seeds_judge_nothing(make_study, seeds):
    found = judged(make_study(seeds=seeds, scenarios=TWO_GRIDS))
    assert all(row["holds"] is None for row in found.values())
    assert found["reward-effect"]["verdict"] == "too few seeds"
    assert len(found["reward-effect"]["evidence"]) == 16


def test_other_grids_count_by_their_intersections(make_study):
    found = judged(make_study(scenarios=("grid:4x4",)))
    assert found["complex-loses-default"]["holds"] is True
    assert found["single-intersection"]["verdict"] == "not run"


def test_failed_runs_are_left_out(make_study):
    folder = make_study(scenarios=("grid:3x3",))
    runs = pl.read_parquet(folder / "runs.parquet")
    failed = (pl.col("seed") == 0) & (pl.col("controller") == "dual-memory")
    runs = runs.with_columns(
        status=pl.when(failed).then(pl.lit("it broke")).otherwise("status"),
        w_over_vc=pl.when(failed).then(None).otherwise("w_over_vc"),
    )
    runs.write_parquet(folder / "runs.parquet")
    (first, *_) = judged(folder)["complex-loses-default"]["evidence"]
    assert first["n"] == 7


@pytest.mark.parametrize(
    ("relation", "threshold", "low", "high", "outcome"),
    [
        ("below", 0.0, -0.2, -0.1, "shown"),
        ("below", 0.0, -0.2, 0.1, "open"),
        ("below", 0.0, 0.1, 0.2, "opposite"),
        ("below", -0.3, -0.29, -0.2, "opposite"),
        ("above", 1.0, 1.1, 1.2, "shown"),
        ("above", 1.0, 0.5, 0.6, "opposite"),
        ("within", 0.05, -0.05, 0.05, "shown"),
        ("within", 0.05, -0.06, 0.01, "open"),
        ("within", 0.05, 0.06, 0.1, "opposite"),
        ("not below", 0.0, -0.1, 0.1, "shown"),
        ("not below", 0.0, -0.2, -0.1, "opposite"),
        ("below", 0.0, float("nan"), float("nan"), "open"),
    ],
)
def test_rules(relation, threshold, low, high, outcome):
    assert judge(relation, threshold, low, high) == outcome
