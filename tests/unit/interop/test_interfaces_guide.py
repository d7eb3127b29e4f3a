"""docs/interfaces.md does what it says."""

import re
from pathlib import Path

import pytest

from dmil.interop import ENVIRONMENTS, parallel_env

GUIDE_FILE = Path(__file__).resolve().parents[3] / "docs" / "interfaces.md"
GUIDE = GUIDE_FILE.read_text(encoding="utf-8")
PROGRAMS = re.findall(r"^```python\n(.*?)^```$", GUIDE, re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("text", PROGRAMS, ids=range(len(PROGRAMS)))
def test_the_programs_of_the_guide_run(text, capsys):
    if "stable_baselines3" in text:
        pytest.importorskip("stable_baselines3", reason="no extra of this package: it brings torch")
    exec(compile(text, "interfaces.md", "exec"), {"__name__": "guide"})
    printed = capsys.readouterr().out
    assert "stable_baselines3" in text or re.match(r"travel time \d+\.\d s", printed)


def test_the_guide_shows_what_there_is():
    assert len(PROGRAMS) == 5
    assert set(re.findall(r"dmil/\w+-v0", GUIDE)) == set(ENVIRONMENTS)


def test_the_table_of_infos_is_complete():
    env = parallel_env("grid:1x1", horizon_s=10)
    env.reset(seed=0)
    *_, infos = env.step({"0,0": 0})
    table = GUIDE.split("| `info` | what |\n|-|-|\n")[1].split("\n\n")[0]
    rows = [re.findall(r"`(\w+)`", row.split("|")[1]) for row in table.splitlines()]
    assert sorted(name for row in rows for name in row) == sorted(infos["0,0"])


@pytest.mark.parametrize("link", sorted(set(re.findall(r"\]\((?!http)([^)#]+)\)", GUIDE))))
def test_every_link_leads_somewhere(link):
    assert (GUIDE_FILE.parent / link).exists()
