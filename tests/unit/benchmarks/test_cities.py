"""Figures of a whole city: there and positive; how large they are is not tested."""

from dmil.benchmarks import cities


def test_the_figures_of_a_city():
    figures = cities.city_figures(side=3, decisions=4)
    assert [figure.name for figure in figures] == [
        "factored memory's decision for 9 intersections",
        "factored memory's decision for 9 intersections with clearance",
    ]
    for figure in figures:
        assert figure.unit == "ms"
        assert figure.value > 0
        assert figure.against is None


def test_every_decision_after_the_first_learns(monkeypatch):
    made = []

    class Kept(cities.FactoredController):
        def reset(self, context):
            made.append(self)
            super().reset(context)

    monkeypatch.setattr(cities, "FactoredController", Kept)
    cities.city_figures(side=2, decisions=5)
    # Eight lanes at each of four intersections, queues of at most twenty.
    assert [int(each.arrays()["times"].sum()) for each in made] == [5 * 8 * 4] * 2
