"""How the command line behaves in a shell: quick help, pipes, colours, modules."""

import os
import subprocess
import sys

import pytest

import dmil as package

HEAVY = ("altair", "duckdb", "numba", "numpy", "polars", "ray", "scipy")


@pytest.mark.parametrize("arguments", [["--help"], ["version"], []])
def test_help_and_version_load_nothing_heavy(arguments):
    code = (
        "import sys, dmil.cli\n"
        f"sys.argv = ['dmil', *{arguments!r}]\n"
        "try: dmil.cli.main()\n"
        "except SystemExit as end: code = end.code\n"
        "print(code, *sys.modules, file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    code, *modules = done.stderr.split()
    assert code == "0"
    assert set(HEAVY).isdisjoint(modules)
    assert "dmil" in done.stdout


def test_a_closed_pipe_is_silent():
    command = f"{sys.executable} -m dmil theory --statements | head -1"
    done = subprocess.run(command, shell=True, capture_output=True, text=True, check=True)
    assert done.stdout.count("\n") == 1
    assert done.stderr == ""


def test_a_terminal_that_knows_no_greek_gets_question_marks(dmil):
    done = dmil.process("theory", PYTHONIOENCODING="ascii")
    assert done.out.startswith("|A| = 8, ? = 0.5, T = 16")


def test_a_pipe_gets_no_colours(dmil):
    for arguments in (["--help"], ["theory"], ["controllers"], ["nonsense"]):
        code = 2 if arguments == ["nonsense"] else 0
        done = dmil.process(*arguments, code=code)
        assert "\x1b" not in done.out + done.err


@pytest.mark.skipif(not hasattr(os, "openpty"), reason="no terminals here")
@pytest.mark.parametrize("variables, coloured", [({}, True), ({"NO_COLOR": "1"}, False)])
def test_a_terminal_gets_colours_unless_it_says_no(variables, coloured):
    leader, follower = os.openpty()
    environment = {k: v for k, v in os.environ.items() if k not in ("NO_COLOR", "TERM")}
    subprocess.run(
        [sys.executable, "-m", "dmil", "controllers"],
        stdout=follower,
        env={**environment, "TERM": "xterm-256color", **variables},
        check=True,
    )
    os.close(follower)
    seen = b""
    try:
        while part := os.read(leader, 65536):
            seen += part
    except OSError:  # the other end is closed
        pass
    os.close(leader)
    assert b"dual-memory" in seen
    assert (b"\x1b[36m" in seen) is coloured


def test_the_module_is_the_command(dmil):
    assert dmil.process("version", "--json").json["dmil"] == package.__version__
