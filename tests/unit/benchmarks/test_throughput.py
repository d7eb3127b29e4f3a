"""The figures of speed: there, positive, compared with each other."""

from dmil.benchmarks.throughput import DUAL, KERNEL, LEARNERS, SARSA, SIMULATOR, throughput_figures


def test_the_figures_of_speed():
    figures = {figure.name: figure for figure in throughput_figures(horizon_s=60, rounds=3)}
    assert set(figures) > {KERNEL, SIMULATOR, *LEARNERS}
    assert all(figure.value > 0 for figure in figures.values())
    assert figures[KERNEL].unit == "steps/s"
    assert figures[DUAL].against == SARSA
    for figure in figures.values():
        if figure.against is not None:
            assert figure.against in figures
            assert figure.ratio_min <= figure.ratio_median <= figure.ratio_max


def test_bench_prints_the_contract(monkeypatch, capsys):
    import json

    from dmil.benchmarks import SpeedFigure
    from dmil.cli import bench

    one, two = SpeedFigure("a", 1500.0, "1/s"), SpeedFigure("b", 0.5, "ns", "a", 2.0, 1.5, 2.5)
    monkeypatch.setattr("dmil.benchmarks.throughput.throughput_figures", lambda: [one])
    monkeypatch.setattr("dmil.benchmarks.lookups.lookup_figures", lambda: [two])
    monkeypatch.setattr("dmil.benchmarks.neighbours.neighbour_figures", lambda: [])
    monkeypatch.setattr("dmil.benchmarks.cities.city_figures", lambda: [])
    monkeypatch.setattr("dmil.cli.bench.SUMO_PACKAGES", ("no_such_package",))
    bench.bench(json=True)
    found = json.loads(capsys.readouterr().out)
    fields = {"name", "value", "unit", "against", "ratio_median", "ratio_min", "ratio_max"}
    assert [set(figure) for figure in found["figures"]] == [fields, fields]
    assert found["figures"][1]["ratio_median"] == 2.0
    bench.bench()
    text = capsys.readouterr().out
    assert "1 500" in text
    assert "2 × a (1.5 to 2.5)" in text
