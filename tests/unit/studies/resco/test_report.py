"""The report of the study on the RESCO benchmark."""

import json
import re

import pytest

from dmil.errors import OutputError, UnknownNameError
from dmil.reports.drawing import draw
from dmil.reports.export import embedded
from dmil.reports.labels import contender_label
from dmil.results import Results
from dmil.studies.report import write_report
from dmil.studies.resco.charts import contender_colours, contender_marks
from dmil.studies.resco.figures import figures_of_network, figures_of_study
from dmil.studies.resco.tables import resco_tables
from tests.unit.made_up_resco import CONTENDERS, QUEUE, SUMO
from tests.unit.studies.paper.test_report import LIMIT_BYTES, _Page, specifications
from tests.unit.vega_lite import check_valid

STUDY_FIGURES = {"delays", "locks", "simulators", "rank_agreement", "memory"}
NETWORK_FIGURES = {"delay_by_simulator", "training", "queues", "memory"}
TWO = ("resco/cologne1", "resco/ingolstadt1")


@pytest.fixture(scope="module")
def study(make_resco_study):
    return make_resco_study(scenarios=TWO)


@pytest.fixture(scope="module")
def tables(study):
    with Results(study) as results:
        return resco_tables(results)


@pytest.fixture(scope="module")
def report(study, tables):
    return write_report(study, tables=tables)


@pytest.fixture(scope="module")
def figures(study, tables):
    found = list(figures_of_study(tables))
    with Results(study) as results:
        for scenario in tables.judged.scenarios:
            found += figures_of_network(results, tables, scenario)
    return found


def text_of(path):
    return " ".join(" ".join(_Page(path.read_text()).text).split())


def test_there_is_a_page_for_the_study_and_one_for_each_network(report):
    pages = {path.name for path in (report.parent / "scenarios").glob("*.html")}
    assert pages == {"cologne1.html", "ingolstadt1.html"}


@pytest.mark.parametrize("name", ["report.html", "scenarios/cologne1.html"])
def test_pages_are_well_formed_and_need_nothing_from_outside(report, name):
    path = report.parent / name
    page = _Page(path.read_text())
    assert len(page.ids) == len(set(page.ids))
    for address in page.addresses:
        assert address.startswith("#") or (path.parent / address).is_file(), address
    inside = {address[1:] for address in page.addresses if address.startswith("#")}
    assert inside <= set(page.ids)
    assert path.stat().st_size < LIMIT_BYTES


def test_every_figure_has_its_place_and_its_data(report):
    for name, expected in (
        ("report.html", STUDY_FIGURES),
        ("scenarios/cologne1.html", {f"cologne1_{each}" for each in NETWORK_FIGURES}),
    ):
        text = (report.parent / name).read_text()
        places = {i.removeprefix("figure-") for i in _Page(text).ids if i.startswith("figure-")}
        # The picture of a network needs its files, which need not be installed.
        assert expected <= places <= expected | {"cologne1_network"}
        found = specifications(text)
        assert found.keys() == places
        for spec in found.values():
            assert "url" not in json.dumps(spec.get("data", {}))


def test_the_main_page_says_what_was_measured_and_published(report):
    text = text_of(report)
    assert "340 of 340 runs, 5 seeds, 2 networks; evaluated in SUMO" in text
    assert "learners trained in queue, calibrated" in text
    assert "publ. 56.6" in text and "26.1 (28.9)" in text and "publ. 39.4" in text
    assert "With 5 seeds the intervals are rough" in text
    assert "Ault and Sharon" in text and "dmil study resco" in text


def test_locked_runs_are_told_of_in_the_table_of_delays_and_in_one_of_their_own(report):
    text = text_of(report)
    assert text.count("1 of 5 locked") == 2  # random, on both networks
    assert "1 of 5 [4, 62] %" in text and "0 of 5 [0, 43] %" in text


def test_the_best_are_marked_by_their_intervals(tables, report):
    marked = tables.headline["among_best"].sum()
    cells = re.findall(r'<td class="r best">', report.read_text())
    assert len(cells) == marked >= 2


def test_a_networks_page_has_all_its_metrics(report):
    text = text_of(report.parent / "scenarios" / "cologne1.html")
    for word in (
        "stops per vehicle",
        "CO2, kg",
        "requests overruled",
        "difference to max-pressure",
    ):
        assert word in text
    assert "vehicles 2,000" in text and "published IDQN 100 26.1 28.9" in text


def test_pictures_and_tables_are_files(report):
    names = {path.stem for path in (report.parent / "figures").iterdir()}
    assert names >= STUDY_FIGURES and {f"ingolstadt1_{n}" for n in NETWORK_FIGURES} <= names
    for name in STUDY_FIGURES:
        for ending, magic in ((".png", b"\x89PNG"), (".pdf", b"%PDF"), (".svg", b"<svg")):
            data = (report.parent / "figures" / (name + ending)).read_bytes()
            assert data.startswith(magic) and len(data) > 2_000
    tables = {path.name for path in (report.parent / "tables").iterdir()}
    assert {"delay.csv", "delay.tex", "metrics.csv", "agreement.csv", "agreement.tex"} <= tables
    assert {"overall.csv", "training.csv", "published.csv"} <= tables


def test_latex_has_a_row_for_every_controller_and_published_method(report):
    latex = (report.parent / "tables" / "delay.tex").read_text()
    rows = [line for line in latex.splitlines() if line.endswith(r"\\")]
    assert len(rows) == 1 + len(CONTENDERS) + 7
    assert all(line.count("&") == len(TWO) for line in rows)
    assert latex.index(r"\toprule") < latex.index(r"\midrule") < latex.index(r"\bottomrule")
    assert "26.1 (28.9)" in latex and "$^{*}$" in latex
    latex = (report.parent / "tables" / "agreement.tex").read_text()
    rows = [line for line in latex.splitlines() if line.endswith(r"\\")]
    assert len(rows) == 1 + len(TWO) + 1 and all(line.count("&") == 4 for line in rows)


def test_the_same_results_give_the_same_files(study, report, figures):
    kept = (".csv", ".tex", ".html")
    before = {p: p.read_bytes() for p in report.parent.rglob("*") if p.suffix in kept}
    write_report(study, pictures=False)
    for figure in figures[::5]:
        drawn = report.parent / f"figures/{figure.name}.svg"
        assert drawn.read_bytes() == draw(figure.spec, ["svg"])["svg"]
    assert [path.name for path, data in before.items() if path.read_bytes() != data] == []
    assert [p for p in report.parent.rglob("*") if p.name.startswith(".")] == []


def test_every_specification_is_valid_vega_lite(figures):
    assert len(figures) == len(STUDY_FIGURES) + 2 * len(NETWORK_FIGURES)
    for figure in figures:
        check_valid(figure.spec)
        assert figure.caption.endswith(".")


def test_figures_carry_no_raw_runs(figures):
    for figure in figures:
        assert len(embedded(figure.spec)) < 150_000
        assert '"seed"' not in embedded(figure.spec)


def rows_of(figure):
    return [row for rows in figure.spec["datasets"].values() for row in rows]


def test_training_curves_stand_beside_max_pressure_and_the_best_published(figures):
    (figure,) = (f for f in figures if f.name == "cologne1_training")
    ends = {row["line"]: row["mean"] for row in rows_of(figure)}
    assert ends["published IDQN"] == 26.1
    assert ends["max-pressure"] == pytest.approx(36, rel=0.15)
    assert len(ends) == 2 + 7


def test_approaching_changes_the_name_and_not_the_colour():
    name = "max-pressure,approaching=true"
    assert contender_label(name) == "max-pressure + approaching"
    one, other = contender_colours(["max-pressure", contender_label(name)])
    assert one == other
    shapes = contender_marks(["max-pressure", contender_label(name)])[1].to_dict()["scale"]["range"]
    assert len(set(shapes)) == 2


def test_what_trained_in_sumo_has_a_figure_of_its_own(make_resco_study):
    folder = make_resco_study(scenarios=("resco/cologne1",), trained_in={"sarsa": SUMO})
    with Results(folder) as results:
        made = resco_tables(results)
        found = {f.name: f for f in figures_of_network(results, made, "resco/cologne1")}
    assert made.judged.trained_in == ("queue-calibrated", SUMO)
    lines = {row["line"] for row in rows_of(found["cologne1_training_in_sumo"])}
    assert lines == {"SARSA exact", "max-pressure", "published IDQN"}
    assert "SARSA exact" not in {row["line"] for row in rows_of(found["cologne1_training"])}


def test_colours_tell_embeddings_apart_and_shapes_communication():
    names = ["Dual memory simple", "Dual memory simple + comm.", "Dual memory cells", "SARSA exact"]
    found = contender_colours(names)
    assert found[0] == found[1] and len(set(found)) == 3
    shapes = contender_marks(names)[1].to_dict()["scale"]["range"]
    assert shapes == ["circle", "diamond", "circle", "circle"]


SOME = [CONTENDERS[k] for k in (0, 1, 3, 5, 6, 11)]
PARTIAL = {
    "one seed": ({"seeds": 1}, "One seed: no intervals"),
    "no queue simulator": ({"simulators": (SUMO,)}, "evaluated in SUMO"),
    "no calibration": ({"simulators": (SUMO, QUEUE)}, "evaluated in SUMO"),
    "no SUMO": ({"simulators": (QUEUE,)}, "No run in SUMO succeeded"),
    "baselines only": ({"contenders": [each for each in SOME if each[1] is None]}, ""),
    "learners only": ({"contenders": [each for each in SOME if each[1] is not None]}, ""),
    "one controller": ({"contenders": [("max-pressure", None, False)]}, ""),
    "one episode": ({"episodes": 1}, ""),
    "failures": (
        {"failed": {("max-pressure", SUMO), ("program", QUEUE)}},
        "4 runs failed and are left out. One of them: SimulationError: SUMO died",
    ),
    "another network": ({"scenarios": ("sumo:town.sumocfg",)}, ""),
}
ONE = {"scenarios": ("resco/cologne1",), "seeds": 2, "contenders": SOME}


@pytest.mark.parametrize("name", PARTIAL)
def test_partial_studies_have_a_report(make_resco_study, name):
    options, said = PARTIAL[name]
    folder = make_resco_study(**ONE | options)
    path = write_report(folder, pictures=False)
    assert said in text_of(path)
    assert not (path.parent / "figures").exists()
    drawn = 0
    for page in (path, *path.parent.glob("scenarios/*.html")):
        text = page.read_text()
        _Page(text)
        for spec in specifications(text).values():
            assert draw(spec, ["svg"])["svg"].startswith(b"<svg")
            drawn += 1
    assert drawn > 2


def test_text_from_a_study_is_no_markup(make_resco_study):
    folder = make_resco_study(**ONE)
    manifest = json.loads((folder / "manifest.json").read_text())
    manifest["command"] = "dmil study '<script>alert(1)</script>'"
    (folder / "manifest.json").write_text(json.dumps(manifest))
    assert "<script>alert(1)" not in write_report(folder, pictures=False).read_text()


def test_another_preset_or_study_is_refused(make_resco_study):
    folder = make_resco_study(**ONE)
    with pytest.raises(UnknownNameError, match="matched"):
        write_report(folder, preset="matched")
    manifest = json.loads((folder / "manifest.json").read_text())
    (folder / "manifest.json").write_text(json.dumps(manifest | {"study": "mine"}))
    with pytest.raises(OutputError, match="no report for a study 'mine'"):
        write_report(folder)
    assert not (folder / "report.html").exists()
