"""The README's own commands and its library example, as they stand there."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)


COMMANDS = [
    shlex.split(line, comments=True)[1:]
    for block in blocks("sh")
    for line in block.splitlines()
    if line.startswith("dmil ")
]


def test_the_readme_has_commands():
    assert {"train", "evaluate", "simulate", "study", "theory", "controllers"} == {
        command[0] for command in COMMANDS
    }


def test_every_command_works_in_its_order(dmil, city, tmp_path):
    folder = city()
    (tmp_path / "work").mkdir()
    for command in COMMANDS:
        arguments = [argument.replace("FOLDER", str(folder)) for argument in command]
        done = dmil(*arguments, cwd=tmp_path / "work")
        assert done.out.strip()
    assert (tmp_path / "work" / "policy.npz").is_file()
    assert (tmp_path / "work" / "quick" / "report.html").is_file()


@pytest.mark.parametrize("source", blocks("python"))
def test_the_library_example_runs_and_compares(source, tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", source],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert len(lines) == 4
    assert [line.startswith("max-pressure") for line in lines] == [False, True] * 2


def test_the_two_commands_are_targets_of_the_makefile():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for line in re.findall(r"^make (\w+)", README, re.MULTILINE):
        assert re.search(rf"^{line}:", makefile, re.MULTILINE)


@pytest.mark.parametrize("link", sorted(set(re.findall(r"\]\(([^)#]+)\)", README))))
def test_every_link_leads_somewhere(link):
    assert (ROOT / link).exists()
