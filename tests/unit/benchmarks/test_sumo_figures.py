"""Figures beside SUMO: there, positive, compared with each other; the busy grid is as described."""

import importlib.util
import json

import numpy as np
import pytest

from dmil.benchmarks import SpeedFigure
from dmil.benchmarks.sumo import busy_grid, sumo_figures
from dmil.cli import bench
from dmil.network.checks import check_network
from dmil.training import vehicles_of_seed


@pytest.mark.skipif(
    not all(map(importlib.util.find_spec, bench.SUMO_PACKAGES)), reason="needs the extra sumo"
)
def test_the_figures_beside_sumo():
    figures = {figure.name: figure for figure in sumo_figures(horizon_s=20, rounds=2)}
    assert len(figures) == 10
    assert all(figure.value > 0 for figure in figures.values())
    compared = [figure for figure in figures.values() if figure.against]
    assert len(compared) == 6
    for figure in compared:
        assert figure.against in figures
        assert 0 < figure.ratio_min <= figure.ratio_median <= figure.ratio_max


def test_the_busy_grid():
    made = busy_grid()
    check_network(made.network)
    assert {link.length_m for link in made.network.links} == {800.0, 600.0}
    for link in made.network.links:
        ends = [np.array(made.network.position_m[node]) for node in (link.start, link.end)]
        assert np.abs(ends[0] - ends[1]).sum() == pytest.approx(link.length_m)
    assert len(vehicles_of_seed(made, 0)) == pytest.approx(3000, rel=0.1)
    assert {item.program.cycle_s for item in made.network.intersections} == {120.0}


def test_bench_adds_them(monkeypatch, capsys):
    for module in (
        "throughput.throughput",
        "lookups.lookup",
        "neighbours.neighbour",
        "cities.city",
    ):
        monkeypatch.setattr(f"dmil.benchmarks.{module}_figures", lambda: [])
    monkeypatch.setattr("dmil.cli.bench.SUMO_PACKAGES", ())
    monkeypatch.setattr("dmil.benchmarks.sumo.sumo_figures", lambda: [SpeedFigure("x", 2.0, "1/s")])
    bench.bench(json=True)
    assert [item["name"] for item in json.loads(capsys.readouterr().out)["figures"]] == ["x"]
