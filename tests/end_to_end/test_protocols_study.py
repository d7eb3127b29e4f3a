"""``dmil study protocols`` from outside: a crossing that stands in for one city's day."""

import json

import pytest

from dmil.results import Results
from dmil.simulation.cityflow.process import has_cityflow
from dmil.studies.protocols.recipes import CITIES
from tests.unit.cityflow.conftest import crossing_document

VEHICLE = {"length": 5.0, "width": 2.0, "maxPosAcc": 2.0, "maxNegAcc": 4.5, "usualPosAcc": 2.0}
VEHICLE |= {"usualNegAcc": 4.5, "minGap": 2.5, "maxSpeed": 11.111, "headwayTime": 2}
TINY = ("study", "protocols", "--data", "data", "--protocols", "dmil-15-5", "--seeds", "3")
TINY += ("--controllers", "max-pressure,combined", "--steps", "300")


@pytest.fixture(scope="module")
def city(tmp_path_factory):
    """A folder with one city of one intersection."""
    folder = tmp_path_factory.mktemp("protocols")
    name, flow = CITIES["JN1"]
    (folder / "data" / name).mkdir(parents=True)
    flows = [
        {
            "vehicle": VEHICLE,
            "route": [f"{a}_in", f"{b}_out"],
            "interval": 6,
            "startTime": k,
            "endTime": 200,
        }
        for k, (a, b) in enumerate((("E", "W"), ("N", "S")))
    ]
    (folder / "data" / name / "roadnet.json").write_text(json.dumps(crossing_document()[0]))
    (folder / "data" / name / flow).write_text(json.dumps(flows))
    return folder


@pytest.fixture(scope="module")
def ran(dmil, city):
    """The study in the queue simulator or in both, with its report, and its JSON."""
    return dmil(*TINY, "--cities", "JN1", "--jobs", 2, "--json", cwd=city)


def test_the_figures_are_those_of_the_runs(ran, city):
    simulators = {"queue", "cityflow"} if has_cityflow() else {"queue"}
    with Results(city / "protocols") as results:
        runs = {
            (row["simulator"], row["controller"], row["seed"]): row["travel_time_s"]
            for row in results.runs().iter_rows(named=True)
        }
    shown = ran.json["ours"]
    assert {row["simulator"] for row in shown} == simulators
    for row in shown:
        where = row["simulator"], row["controller"]
        assert row["recorded_s"] == runs[(*where, 0)]
        assert row["mean_s"] == pytest.approx((runs[(*where, 1)] + runs[(*where, 2)]) / 2)
    # No figure was published for this recipe.
    assert ran.json["published"] == []
    page = (city / "protocols" / "report.html").read_text()
    assert f"{shown[0]['recorded_s']:.1f}" in page and "combined" in page


def test_the_same_bytes_in_one_process_and_tables_of_80_columns(dmil, ran, city):
    done = dmil(*TINY, "--cities", "JN1", "--jobs", 1, "--out", "one", cwd=city)
    one, two = ((city / name / "runs.parquet").read_bytes() for name in ("one", "protocols"))
    assert one == two
    # A sentence is one line where it is piped.
    table = [line for line in done.out.splitlines() if not line.endswith(".")]
    assert max(map(len, table)) <= 80
    assert "max-pressure" in done.out and "…" not in done.out


def test_a_city_that_is_not_there_is_one_error(dmil, city):
    done = dmil(*TINY, "--cities", "HZ1", "--out", "none", cwd=city, code=2)
    assert "HZ1" in done.err and "Traceback" not in done.err
    assert not (city / "none").exists()
