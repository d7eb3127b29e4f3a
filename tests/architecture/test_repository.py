"""What no committed file contains: a path of one machine, or the address of a package index."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
MACHINE_PATH = re.compile(rb"(?<![\w.~-])/(?:work|root|home|Users)/")
INDEX = re.compile(rb"\bpypi\.(?:org|python)|python" rb"hosted")


def committed() -> list[Path]:
    if not (ROOT / ".git").exists() or shutil.which("git") is None:
        pytest.skip("not a git checkout")
    command = ["git", "-c", "safe.directory=*", "ls-files", "-z"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    paths = [ROOT / name for name in done.stdout.split("\0") if name]
    return [path for path in paths if path.is_file()]


@pytest.mark.parametrize("pattern", [MACHINE_PATH, INDEX], ids=["machine path", "index address"])
def test_no_file_is_tied_to_a_machine(pattern):
    found = [
        f"{path.relative_to(ROOT)}: {match[0].decode()}"
        for path in committed()
        for match in pattern.finditer(path.read_bytes())
    ]
    assert found == []


@pytest.mark.parametrize(
    "text",
    ["open('/{}/data')", "/{}/someone/x", "out = /{}/a", '"/{}/"'],
)
@pytest.mark.parametrize("folder", ["work", "root", "home", "Users"])
def test_the_pattern_finds_machine_paths(text, folder):
    assert MACHINE_PATH.search(text.format(folder).encode())


@pytest.mark.parametrize("text", ["net/{}/a", "../{}/a", "~/{}/a", "example.org/{}/"])
def test_the_pattern_leaves_other_paths_alone(text):
    assert not MACHINE_PATH.search(text.format("work").encode())


def test_the_pattern_finds_an_index_address():
    assert INDEX.search(".".join(["https://pypi", "org"]).encode())
    assert INDEX.search(("files.python" + "hosted.org").encode())
