"""What goes where, and what the end of a command means."""

import json
from pathlib import Path

import numpy as np
import pytest
import typer

from dmil.cli import terminal
from dmil.cli.application import StoppedError, exit_code
from dmil.cli.terminal import number
from dmil.errors import DmilError


@pytest.fixture(autouse=True)
def wide(monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("NO_COLOR", "1")


def raising(error):
    def run():
        raise error

    return run


def test_json_has_plain_values(capsys):
    value = {"a": np.float64("nan"), "b": [np.int64(3), float("inf")], "c": Path("x"), 4: (True,)}
    terminal.print_json(value)
    captured = capsys.readouterr()
    assert json.loads(captured.out) == {"a": None, "b": [3, None], "c": "x", "4": [True]}
    assert captured.err == ""


def test_long_messages_stay_on_one_line(capsys):
    terminal.say("x" * 200)
    terminal.print_error("[y] " * 60)
    captured = capsys.readouterr()
    assert captured.err.splitlines() == ["x" * 200, "error: " + "[y] " * 60]
    assert captured.out == ""


def test_progress_without_a_terminal_is_a_line_every_tenth(capsys):
    with terminal.progress("runs") as advance:
        for done in range(41):
            advance(done, 40)
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 10
    assert lines[0].startswith("4 of 40 runs, 10 %, ")
    assert lines[-1].startswith("40 of 40 runs, 100 %, 0 s left")


def test_progress_counts_from_what_is_there(capsys):
    with terminal.progress("blocks") as advance:
        advance(7, 10)
        advance(8, 10)
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "7 of 10 blocks are there already"
    assert lines[1].startswith("8 of 10 blocks, 80 %")


def test_progress_of_nothing_is_silent(capsys):
    with terminal.progress("blocks") as advance:
        advance(0, 0)
    assert capsys.readouterr().err == ""


def test_a_terminal_gets_a_bar(capsys, monkeypatch):
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TTY_COMPATIBLE", "1")
    with terminal.progress("runs", first_word="starting") as advance:
        advance(0, 3)
        advance(2, 3)
    captured = capsys.readouterr()
    assert "2/3" in captured.err
    assert captured.out == ""


def test_all_is_well(capsys):
    assert exit_code(lambda: None, []) == 0
    assert exit_code(lambda: 3, []) == 3
    assert capsys.readouterr().err == ""


def test_the_users_error_is_2(capsys):
    assert exit_code(raising(DmilError("mend it")), []) == 2
    assert capsys.readouterr().err == "error: mend it\n"
    assert exit_code(raising(typer.BadParameter("no such thing")), ["--json"]) == 2
    captured = capsys.readouterr()
    assert json.loads(captured.out)["error"].endswith("no such thing")


def test_being_stopped_is_1(capsys):
    assert exit_code(raising(StoppedError("go on like this")), []) == 1
    assert capsys.readouterr().err == "stopped: go on like this\n"
    assert exit_code(raising(KeyboardInterrupt()), ["--json"]) == 1
    captured = capsys.readouterr()
    assert captured.err == "stopped\n"
    assert json.loads(captured.out) == {"error": "stopped"}


def test_a_failure_of_the_program_shows_where(capsys):
    assert exit_code(raising(ZeroDivisionError("by zero")), ["--json"]) == 1
    captured = capsys.readouterr()
    assert "Traceback" in captured.err
    assert json.loads(captured.out) == {"error": "ZeroDivisionError: by zero"}


def test_debugging_shows_where_the_users_error_arose(capsys, monkeypatch):
    exit_code(raising(DmilError("mend it")), ["--debug"])
    assert "Traceback" in capsys.readouterr().err
    monkeypatch.setenv("DMIL_DEBUG", "1")
    exit_code(raising(StoppedError("")), [])
    assert "Traceback" in capsys.readouterr().err


def test_numbers_have_true_signs_and_gaps():
    assert number(-1.25, 1) == "−1.2"
    assert number(3.0, 1, "+") == "+3.0"
    assert number(float("nan"), 2) == "–"
