"""docs/extending.md and examples/own_controller.py do what they say."""

import importlib
import importlib.util
import re
import shlex
import sys
from pathlib import Path

import pytest

from dmil.cli import app
from dmil.testing import ControllerRule, RewardRule, SimulatorRule

ROOT = Path(__file__).resolve().parents[3]
GUIDE = (ROOT / "docs" / "extending.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w*)\n(.*?)^```$", GUIDE, re.MULTILINE | re.DOTALL)
FILES = ("my_module.py", "test_my_module.py")


def file_of(text):
    first = text.split("\n", 1)[0].removeprefix("# ")
    return first if first in FILES else None


PROGRAMS = [text for language, text in BLOCKS if language == "python" and not file_of(text)]
COMMANDS = [line for language, text in BLOCKS if language == "sh" for line in text.splitlines()]
TESTS = re.findall(r"^def (test_\w+)", GUIDE, re.MULTILINE)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with the guide's files, where a user would be."""
    folder = tmp_path_factory.mktemp("extending")
    for name in FILES:
        parts = (text for language, text in BLOCKS if language == "python")
        (folder / name).write_text("\n".join(text for text in parts if file_of(text) == name))
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setattr(sys, "path", [*sys.path, str(folder)])
        yield folder
    for name in FILES:
        sys.modules.pop(name.removesuffix(".py"), None)


def test_every_block_is_run_in_one_way_or_another():
    assert {language for language, _ in BLOCKS} == {"python", "sh"}
    assert len(PROGRAMS) >= 2
    assert len(TESTS) >= 5
    assert len(BLOCKS) * 2 == GUIDE.count("```")


@pytest.mark.parametrize("name", TESTS)
def test_the_tests_of_the_guide_pass(folder, name):
    getattr(importlib.import_module("test_my_module"), name)()


@pytest.mark.parametrize("text", PROGRAMS, ids=range(len(PROGRAMS)))
def test_the_programs_of_the_guide_run(folder, text, capsys):
    exec(compile(text, "extending.md", "exec"), {})
    assert re.search(r"W/V_c = 0\.\d|\d+ (vehicles|phases)", capsys.readouterr().out)


@pytest.mark.parametrize("line", COMMANDS)
def test_the_commands_of_the_guide_run(folder, line, capsys):
    program, *arguments = shlex.split(line)
    assert program == "dmil"
    with pytest.raises(SystemExit) as ended:
        app(arguments)
    said = capsys.readouterr()
    assert ended.value.code == 0, said.err
    assert "travel time" in said.out.lower()


@pytest.mark.parametrize(
    ("rules", "kind"),
    [(ControllerRule, "controller"), (RewardRule, "reward"), (SimulatorRule, "simulator")],
)
def test_the_tables_hold_all_rules(rules, kind):
    table = GUIDE.split(f"| rule | what every {kind} keeps |\n|-|-|\n")[1].split("\n\n")[0]
    assert table.splitlines() == [f"| {rule.name} | {rule.value} |" for rule in rules]


def test_the_example_compares_two_controllers(capsys):
    path = ROOT / "examples" / "own_controller.py"
    spec = importlib.util.spec_from_file_location("own_controller", path)
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    example.main(["--scenario", "grid:1x2", "--seeds", "2"])
    lines = capsys.readouterr().out.splitlines()
    means = {line.split()[0]: float(line.split()[1]) for line in lines[1:3]}
    assert set(means) == {"actuated", "max-pressure"}
    # Looking ahead at queues on all sides must pay.
    assert 0 < means["max-pressure"] < means["actuated"]
    assert lines[3] == "actuated waits less in 0 of 2 seeds"
