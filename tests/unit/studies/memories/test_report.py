"""The report of the study of memories."""

import json
import re

import pytest

from dmil.errors import UnknownNameError
from dmil.reports.contenders import dashes, palette
from dmil.reports.export import embedded
from dmil.reports.labels import colours_by_label
from dmil.reports.marks import ticks
from dmil.reports.sheet import label_places
from dmil.reports.theme import DARK_BACKGROUND
from dmil.studies.memories.figures import DARK, figures_of_study
from dmil.studies.report import write_report
from tests.unit.made_up_memories import CELLS, CONTROLLERS, write_made_up_study
from tests.unit.studies.paper.test_report import LIMIT_BYTES, _Page
from tests.unit.vega_lite import check_valid

FIGURES = {
    *("differences", "standing", "profile", "waiting-and-bytes", "memory-over-time"),
    *("learning", "ablation", "differences-dark"),
}


@pytest.fixture(scope="module")
def report(memories_study, made_up_memories):
    return write_report(memories_study, pictures=False, tables=made_up_memories)


@pytest.fixture(scope="module")
def figures(made_up_memories):
    return {figure.name: figure for figure in figures_of_study(made_up_memories)}


def text_of(path):
    return " ".join(" ".join(_Page(path.read_text()).text).split())


def rows_of(figure):
    """Return the rows of all data of a figure."""
    return [row for rows in figure.spec["datasets"].values() for row in rows]


def test_the_page_is_well_formed_and_needs_nothing_from_outside(report):
    page = _Page(report.read_text())
    assert len(page.ids) == len(set(page.ids))
    inside = {address[1:] for address in page.addresses if address.startswith("#")}
    assert inside <= set(page.ids)
    for address in page.addresses:
        if not address.startswith("#") and not address.startswith("figures/"):
            assert (report.parent / address).is_file(), address
    assert report.stat().st_size < LIMIT_BYTES


def test_every_figure_is_valid_and_has_its_place(figures, report):
    assert figures.keys() == FIGURES
    text = report.read_text()
    for name, figure in figures.items():
        check_valid(figure.spec)
        assert figure.caption
        shown = f'id="figure-{name}"' in text
        assert shown == (figure.section != DARK)
        assert (embedded(figure.spec) in text) == shown


def test_there_is_a_section_for_every_claim_with_its_verdict(report, made_up_memories):
    claims = made_up_memories.claims
    page = report.read_text()
    text = text_of(report)
    for row in claims.iter_rows(named=True):
        assert f'id="claim-{row["id"]}"' in page
        assert row["sentence"] in text and row["verdict"] in text
    assert "8 of 8 targets are met" in text


def test_what_failed_and_what_was_tuned_is_said(report):
    text = text_of(report)
    assert "1 run failed" in text and "DivergedError: values are not finite at 70 s" in text
    assert "neighbours = 7" in text
    assert "1991 of 2000 57 31.41 27.18 −13.5 [−21.0, −8.0]" in text
    assert "Recorded cities (Jinan, Hangzhou) were left out" not in text


def test_cities_that_are_missing_are_named_with_what_to_do(tmp_path):
    cells = [cell for cell in CELLS if not cell[0].startswith("city")]
    folder = write_made_up_study(tmp_path / "grids", seeds=1, cells=cells)
    text = text_of(write_report(folder, pictures=False))
    assert "Recorded cities (Jinan, Hangzhou) were left out" in text
    assert "--data DIR" in text and "DMIL_DATA" in text
    assert "One seed: no intervals and no verdicts." in text


def test_the_headline_shows_ours_beside_the_honest_baseline(figures):
    rows = [row for row in rows_of(figures["differences"]) if "where" in row]
    assert {row["name"] for row in rows} == {
        *("factored", "lookahead", "longest queue", "longest queue + approaching"),
    }
    ours = [row for row in rows if row["name"] == "factored"]
    assert len(ours) == 13 and all(row["low"] < row["mean"] < row["high"] < 0 for row in ours)


def test_the_headline_has_a_picture_for_dark_pages(figures):
    light, dark = figures["differences"].spec, figures["differences-dark"].spec
    assert dark["config"]["background"] == DARK_BACKGROUND
    assert light["config"]["background"] == "white"
    assert rows_of(figures["differences"]) == rows_of(figures["differences-dark"])
    ink = re.compile(r'"#222222"')
    assert ink.search(json.dumps(light)) and not ink.search(json.dumps(dark))


def test_a_table_for_the_readme_has_a_row_for_every_cell(report):
    lines = (report.parent / "tables" / "standing.md").read_text().splitlines()
    assert lines[0].startswith("| W in s | max-pressure | longest queue |")
    assert len(lines) == 2 + 13
    assert len({line.count("|") for line in lines}) == 1
    latex = (report.parent / "tables" / "standing.tex").read_text()
    assert latex.count(r"\\") == 14 and "%" not in latex.split("\n", 1)[1].replace(r"\%", "")


def test_another_preset_is_refused(memories_study):
    with pytest.raises(UnknownNameError, match="memories"):
        write_report(memories_study, preset="literal", pictures=False)


def test_options_change_dashes_and_only_shades_of_the_catalogue_change_colours():
    found = palette(list(CONTROLLERS))
    assert found["dual memory, ε .05"] == palette(["dual-memory"])["dual memory"]
    assert found["SARSA, complex classes, ε .05"] == colours_by_label()["SARSA complex"]
    assert found["longest queue"] != found["longest queue + approaching"]
    strokes = dashes(list(CONTROLLERS))
    assert strokes["SARSA, ε .05"] != strokes["SARSA, complex classes, ε .05"]


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [
        (1_500, 2_000_000, [10_000, 100_000, 1_000_000]),
        (0.8, 7.0, [1, 2, 5]),
        (0.98, 1.02, [1.0]),
    ],
)
def test_ticks_are_round_and_few(low, high, expected):
    found = ticks(low, high)
    assert set(expected) <= set(found)
    assert all(low <= value <= high for value in found)
    assert len(found) <= 12


def test_labels_do_not_lie_on_each_other():
    points = [(100.0, 50.0), (104.0, 52.0), (100.0, 62.0), (290.0, 50.0)]
    names = ["first", "second", "third", "at the edge"]
    places = label_places(points, names, size=(300, 100))
    assert places[0].align == "left" and places[3].align == "right"
    anchors = [(place.x, place.y, place.align) for place in places]
    assert len(set(anchors)) == 4
    assert label_places(points, names, size=(300, 100)) == places
