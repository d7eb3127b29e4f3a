import json
import re
from html.parser import HTMLParser
from pathlib import Path

import pytest

import dmil
from dmil.errors import InputError, OutputError, UnknownNameError
from dmil.reports import save_figure
from dmil.reports.drawing import DrawingProcesses, draw, draw_named
from dmil.reports.export import embedded, picture
from dmil.results import Results
from dmil.studies.paper.figures import gallery
from dmil.studies.paper.tables import paper_tables
from dmil.studies.registry import STUDIES
from dmil.studies.report import write_report
from tests.unit.vega_lite import check_valid

LIMIT_BYTES = 3_000_000


@pytest.fixture(scope="module")
def complete(make_study):
    return make_study(presets=("literal", "matched"), scenarios=("grid:1x1", "grid:3x3"), seeds=5)


@pytest.fixture(scope="module")
def tables(complete):
    with Results(complete) as results:
        return paper_tables(results)


@pytest.fixture(scope="module")
def report(complete, tables):
    return write_report(complete, tables=tables)


@pytest.fixture(scope="module")
def figures(complete, tables):
    with Results(complete) as results:
        return list(gallery(results, tables, "matched"))


def specifications(text):
    """Return the specifications in a page by name."""
    found = re.findall(r'^(?:const specifications = { )?"([\w-]+)": ({.*}),$', text, re.MULTILINE)
    return {name: json.loads(spec.replace("<\\/", "</")) for name, spec in found}


class _Page(HTMLParser):
    """Collects ids, addresses and text, and checks that elements are closed in order."""

    VOID = frozenset({"meta", "br", "link", "img", "hr", "input"})

    def __init__(self, page):
        super().__init__()
        self.ids, self.addresses, self.text, self.open = [], [], [], []
        self.feed(page)
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        if tag not in self.VOID:
            self.open.append(tag)
        for name, value in attributes:
            if name == "id":
                self.ids.append(value)
            if name in ("href", "src"):
                self.addresses.append(value)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] not in ("script", "style"):
            self.text.append(data)


@pytest.fixture(scope="module")
def page(report):
    return _Page(report.read_text())


def test_the_page_is_well_formed_and_needs_nothing_from_outside(report, page):
    assert len(page.ids) == len(set(page.ids))
    for address in page.addresses:
        assert address.startswith("#") or (report.parent / address).is_file(), address
    inside = {address[1:] for address in page.addresses if address.startswith("#")}
    assert inside <= set(page.ids)
    assert report.stat().st_size < LIMIT_BYTES


def test_every_figure_has_its_place_and_its_data(report, page):
    places = [name for name in page.ids if name.startswith("figure-")]
    assert len(places) == 17
    found = specifications(report.read_text())
    assert {f"figure-{name}" for name in found} == set(places)
    for spec in found.values():
        assert spec["$schema"].startswith("https://vega.github.io/schema/vega-lite")
        assert "url" not in json.dumps(spec.get("data", {}))


def test_the_headline_comes_from_the_verdicts(tables, page):
    table = tables.claims
    matched = table.filter((table["preset"] == "matched") & (table["source"] != "ours"))
    text = " ".join("".join(page.text).split())
    counted = dict(matched.group_by("outcome").len().rows())
    assert f"Of {matched.height} claims of the paper, with matched: " in text
    # The headline counts what is listed below it.
    for outcome, says, title in (
        ("holds", "hold", "Holds"),
        ("does not hold", "do not hold", "Does not hold"),
        (
            "depends",
            "depend on the reward",
            "Depends on the reward, the reading or the metric",
        ),
        ("not shown", "are not shown", "Not shown"),
    ):
        assert f"{counted[outcome]} {says}" in text
        assert f"{title} ({counted[outcome]})" in text
    assert sum(counted.values()) == matched.height
    assert (
        "Longest queue first and max-pressure, which learn nothing and never explore, beat" in text
    )
    assert "dmil study --seeds 8" in text


def test_pictures_and_tables_are_files(report):
    names = {path.stem for path in (report.parent / "figures").iterdir()}
    assert {"paper_against_ours", "sensitivity", "memory_size_grid-3x3"} <= names
    for name in names:
        for ending, magic in ((".png", b"\x89PNG"), (".pdf", b"%PDF"), (".svg", b"<svg")):
            data = (report.parent / "figures" / (name + ending)).read_bytes()
            assert data.startswith(magic) and len(data) > 2_000
    tables = {path.name for path in (report.parent / "tables").iterdir()}
    assert {"summary.csv", "claims.csv", "claims_evidence.csv", "paper_table_literal.tex"} <= tables
    latex = (report.parent / "tables/paper_table_matched.tex").read_text()
    assert latex.count(r"\\") == 1 + 6 and "[0.08]" in latex
    for line in latex.splitlines():
        if line.endswith(r"\\"):
            assert line.count("&") == 7


def test_the_same_results_give_the_same_files(complete, report, figures):
    before = {path: path.read_bytes() for path in (report, *report.parent.glob("tables/*.csv"))}
    write_report(complete, pictures=False)
    assert len(before) > 5
    assert all(path.read_bytes() == data for path, data in before.items())
    for figure in figures[::8]:
        again = draw(figure.spec, ["svg"])["svg"]
        assert (report.parent / f"figures/{figure.name}.svg").read_bytes() == again


def test_no_temporary_file_is_left(report):
    assert [p for p in report.parent.rglob("*") if p.name.startswith(".")] == []


def test_every_specification_is_valid_vega_lite(figures):
    assert len(figures) == 17
    for figure in figures:
        check_valid(figure.spec)
        assert figure.caption.endswith(".")


def test_figures_carry_no_raw_runs(figures):
    for figure in figures:
        assert len(embedded(figure.spec)) < 60_000
        assert '"seed"' not in embedded(figure.spec)


def test_captions_say_how_large_the_memories_are(figures):
    (figure,) = (f for f in figures if f.name == "states_added_grid-3x3")
    assert "SARSA exact 40 to 67; No Memory 40 to 55; Simple 20 to 28;" in figure.caption


def test_bounds_of_the_theory_lie_above_what_was_stored(figures):
    (figure,) = (f for f in figures if f.name == "memory_size_grid-3x3")
    (rows,) = figure.spec["datasets"].values()
    last = {row["line"]: row["mean"] for row in rows if row["time_s"] == 300}
    # At most one row of 8 values in each of 31 decisions; the made-up run has .9 of one in 30.
    assert last["most possible, SARSA"] == 8 * 31
    assert last["SARSA exact"] == pytest.approx(8 * 27)
    assert last["most possible, dual memory"] > last["Simple"]


PARTIAL = {
    "one preset, one grid, two seeds": {"scenarios": ("grid:5x5",), "seeds": 2},
    "one seed": {"scenarios": ("grid:3x3",), "seeds": 1},
    "another grid": {"scenarios": ("grid:2x4",), "seeds": 3},
    "one intersection": {"scenarios": ("grid:1x1",), "seeds": 3},
    "another network": {"scenarios": ("cityflow:town-1",), "seeds": 3},
    "an unknown preset": {"presets": ("mine",), "scenarios": ("grid:3x3",), "seeds": 2},
    "two presets without matched": {
        "presets": ("literal", "decaying"),
        "scenarios": ("grid:3x3",),
        "seeds": 2,
    },
}


@pytest.mark.parametrize("name", PARTIAL)
def test_partial_studies_have_a_report(make_study, name):
    path = write_report(make_study(**PARTIAL[name]), pictures=False)
    page = _Page(path.read_text())
    assert "Claims and verdicts" in page.text
    text = " ".join("".join(page.text).split())
    assert ("One seed: no intervals and no verdicts." in text) == (name == "one seed")
    assert name != "one seed" or "These runs cannot test any claim of the paper" in text
    assert "not comparable" not in text
    assert not (path.parent / "figures").exists()


MISSING = {
    "baselines only": lambda cell: cell["reward"] is None,
    "learners only": lambda cell: cell["reward"] is not None,
    "one agent": lambda cell: cell["controller"] == "dual-memory" and cell["reward"] == "default",
    "one baseline": lambda cell: cell["controller"] == "random",
    "no sarsa": lambda cell: cell["controller"] != "sarsa",
}


@pytest.mark.parametrize("name", MISSING)
def test_missing_controllers_are_no_obstacle(make_study, name):
    cells = [cell for cell in make_study.cells() if MISSING[name](cell)]
    folder = make_study(cells=cells, scenarios=("grid:3x3",), seeds=2)
    found = specifications(write_report(folder, pictures=False).read_text())
    assert found or name == "one baseline"
    for spec in found.values():
        assert draw(spec, ["svg"])["svg"].startswith(b"<svg")


@pytest.fixture(scope="module")
def retold(make_study):
    """A page with another load than the paper's and a command full of markup."""
    cells = [cell for cell in make_study.cells() if cell["reward"] is None]
    folder = make_study(cells=cells, scenarios=("grid:1x1",), seeds=2)
    manifest = json.loads((folder / "manifest.json").read_text())
    manifest["configuration"]["load"] = 3.0
    manifest["command"] = "dmil study '<script>alert(1)</script>'"
    (folder / "manifest.json").write_text(json.dumps(manifest))
    return write_report(folder, pictures=False).read_text()


def test_another_setting_than_the_papers_is_said(retold):
    assert "so the two are not comparable" in retold


def test_text_from_a_study_is_no_markup(retold):
    assert "<script>alert(1)" not in retold
    assert "alert(1)" in retold


def test_a_folder_without_results_gets_no_report(tmp_path):
    with pytest.raises(OutputError):
        write_report(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_an_unknown_preset_is_refused_before_anything_is_written(make_study):
    folder = make_study(cells=make_study.cells(("default",)), scenarios=("grid:1x1",), seeds=2)
    with pytest.raises(UnknownNameError, match="Did you mean 'matched'"):
        write_report(folder, preset="match")
    assert not (folder / "tables").exists()


@pytest.mark.parametrize("format", ["svg", "png", "pdf", "html"])
def test_one_figure_in_every_format(figures, tmp_path, format):
    data = save_figure(figures[0].spec, tmp_path / f"figure.{format}").read_bytes()
    # A PDF numbers its objects in no fixed order.
    assert len(data) == len(picture(figures[0].spec, format))
    if format == "html":
        assert b"https://cdn" not in data


def test_an_unknown_format_is_refused(tmp_path):
    with pytest.raises(OutputError, match=r"cannot write a figure as '\.gif'"):
        save_figure({}, tmp_path / "figure.gif")
    assert issubclass(OutputError, InputError) and list(tmp_path.iterdir()) == []


def test_the_templates_are_part_of_the_package():
    package = Path(dmil.__file__).parent
    for name in ("layout", "marks", "comparison"):
        assert (package / "reports" / "templates" / f"{name}.html.j2").is_file()
    for name in STUDIES:
        assert (package / "studies" / name / "page.html.j2").is_file()


def test_drawing_processes_draw_what_one_process_draws(figures, tmp_path):
    chosen = sorted(figures, key=lambda figure: len(embedded(figure.spec)))[:3]
    with DrawingProcesses() as drawing:
        for figure in chosen:
            drawing.draw(figure.name, figure.spec)
        pictures = drawing.pictures()
    for figure in chosen:
        (tmp_path / f"{figure.name}.json").write_text(json.dumps(figure.spec))
    draw_named(tmp_path, [f"{figure.name}\n" for figure in chosen])
    assert len(pictures) == 9
    for figure in chosen:
        for format in ("svg", "png"):
            name = f"{figure.name}.{format}"
            assert pictures[name] == (tmp_path / name).read_bytes()


def test_a_figure_that_cannot_be_drawn_is_one_clear_error():
    with (
        pytest.raises(OutputError, match="a figure could not be drawn"),
        DrawingProcesses() as drawing,
    ):
        drawing.draw("nothing", {"mark": "no such mark"})
        drawing.pictures()
