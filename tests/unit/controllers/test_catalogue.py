"""All that is said of a controller stands in the catalogue, and nowhere a second time."""

import re
from pathlib import Path

import dmil
from dmil.controllers import CONTROLLERS, make_controller
from dmil.controllers.entry import Entry, Range
from dmil.controllers.rules.baselines import MaxPressureController, MaxPressureSettings
from dmil.experiments.tuning import search_space
from dmil.reports.contenders import colour_of, controller_name
from dmil.reports.labels import colours_by_label, contender_label, controller_label, dashes_by_label
from dmil.reports.theme import DARK, DARK_BACKGROUND
from dmil.studies.paper.cell_charts import COLOURS
from dmil.studies.resco.charts import contender_colours

PACKAGE = Path(dmil.__file__).parent
CARDS = PACKAGE.parents[1] / "docs" / "controllers"


def test_every_controller_has_a_card_and_every_card_a_controller():
    assert {path.stem for path in CARDS.glob("*.md")} == CONTROLLERS.keys()


def test_no_other_file_names_half_of_the_controllers():
    known = {
        path.relative_to(PACKAGE): [
            name for name in CONTROLLERS if re.search(f"[\"']{name}[\"',]", path.read_text("utf-8"))
        ]
        for path in PACKAGE.rglob("*.*")
        if path.suffix in (".py", ".j2")
    }
    offenders = {str(path) for path, names in known.items() if 2 * len(names) > len(CONTROLLERS)}
    assert offenders == {str(Path("controllers", "catalogue.py"))}


def test_a_family_is_a_folder():
    families = {entry.family for entry in CONTROLLERS.values()}
    assert families == {path.parent.name for path in PACKAGE.glob("controllers/*/__init__.py")}


def test_colours_and_dashes_tell_learners_apart():
    looks = [(each.colour, each.dash) for each in CONTROLLERS.values() if each.learns]
    assert len(set(looks)) == len(looks)
    assert all(re.fullmatch("#[0-9A-Fa-f]{6}", each) for each in colours_by_label().values())


def test_a_controller_has_one_colour_in_all_reports():
    for embedding in ("simple", "complex", "cells"):
        (in_resco,) = contender_colours([contender_label(f"dual-memory {embedding} + comm.")])
        assert colour_of(f"dual-memory,embedding={embedding},epsilon=0.05") == in_resco
    assert COLOURS["Simple"] == colour_of("dual-memory,embedding=simple")
    assert COLOURS["Complex"] == COLOURS["Complex + communication"] == colour_of("dual-memory")
    for name in ("max-pressure", "longest-queue-first", "sarsa"):
        label = controller_label(name)
        assert COLOURS[label] == contender_colours([label])[0] == colour_of(name)


def test_a_new_controller_needs_an_entry_alone(monkeypatch):
    new = Entry(
        MaxPressureController,
        MaxPressureSettings,
        "made up",
        label="Made up",
        colour="#123456",
        dash=(9, 1),
        ranges={"hysteresis": Range(0, 1)},
    )
    monkeypatch.setitem(CONTROLLERS, "made-up", new)
    assert isinstance(make_controller("made-up"), MaxPressureController)
    assert controller_label("made-up") == controller_name("made-up") == "Made up"
    assert contender_label("made-up cells") == "Made up cells"
    assert colour_of("made-up,approaching=true") == contender_colours(["Made up"])[0] == "#123456"
    assert dashes_by_label()["Made up"] == [9, 1]
    assert search_space("made-up")["hysteresis"] == Range(0, 1)


def test_colours_stand_out_on_a_dark_page():
    def luminance(colour):
        parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
        linear = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

    for colour in colours_by_label().values():
        shown = luminance(DARK.get(colour, colour))
        assert (shown + 0.05) / (luminance(DARK_BACKGROUND) + 0.05) > 2.5, colour
