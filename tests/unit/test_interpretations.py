"""The table of what is the paper's and what is ours, against settings and documentation."""

import re
from pathlib import Path

import pytest
from pydantic import BaseModel

from dmil.controllers.tabular.settings import DualMemorySettings, SarsaSettings
from dmil.interpretations import INTERPRETATIONS, MEANING, TOPICS, interpretations_markdown, mark
from dmil.studies.paper.settings import PRESETS, PaperStudySettings, Preset

DOC = Path(__file__).parents[2] / "docs/paper.md"


def fields(kind, prefix=""):
    """Dotted names of all fields with their descriptions."""
    for name, field in kind.model_fields.items():
        yield prefix + name, field.description or ""
        inner = field.annotation
        if isinstance(inner, type) and issubclass(inner, BaseModel):
            yield from fields(inner, f"{prefix}{name}.")


STUDY = dict(fields(PaperStudySettings)) | dict(fields(Preset))
AGENTS = dict(fields(SarsaSettings)) | dict(fields(DualMemorySettings))


@pytest.mark.parametrize("topic", TOPICS)
def test_the_documentation_has_the_table(topic):
    section = DOC.read_text().split(f"## {topic}\n")[1].split("\n## ")[0]
    assert interpretations_markdown(topic) in section


def test_every_choice_says_what_the_paper_says_and_where_it_comes_from():
    assert len({(each.topic, each.what) for each in INTERPRETATIONS}) == len(INTERPRETATIONS)
    for each in INTERPRETATIONS:
        assert each.what and each.paper and each.here and each.mark in MEANING
        # A setting can be changed, or it is a preset's.
        assert bool(each.setting) == bool(each.change)


@pytest.mark.parametrize("setting", [each.setting for each in INTERPRETATIONS if each.setting])
def test_every_setting_of_the_table_is_a_field(setting):
    assert setting in STUDY or setting in AGENTS


def test_descriptions_carry_the_marks_of_the_table():
    found = set()
    for name, description in (STUDY | AGENTS).items():
        setting = name.removeprefix("sarsa.").removeprefix("dual_memory.")
        for given in re.findall(r"\[([PAF])\]", description):
            if setting in ("grids", "rewards", "reward_constants"):
                assert given == "P"
                continue
            key = setting if setting != "timing" else "timing.decision_interval_s"
            assert f"[{given}]" == mark(key), name
            found.add(key)
    assert {"learning_rate", "short_capacity", "scale_levels", "ties", "horizon_s"} <= found
    assert PRESETS["matched"].training_factor == 10


def test_an_unknown_setting_has_no_mark():
    with pytest.raises(KeyError):
        mark("colour")
