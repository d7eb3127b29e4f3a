"""Rules that every source file keeps: one source of randomness, names, length, docstrings."""

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "src" / "dmil"
SOURCES = sorted(PACKAGE.rglob("*.py"))
FILES = [
    *SOURCES,
    *sorted((ROOT / "tests").rglob("*.py")),
    *sorted((ROOT / "scripts").glob("*.py")),
]
ATTICS = {"utils", "util", "common", "core", "helpers", "helper", "manager", "managers", "misc"}
LONGEST = 350


@cache
def parsed(path: Path) -> ast.Module:
    """Parse a file once for all rules."""
    return ast.parse(path.read_text())


def words(path: Path) -> set[str]:
    """Return all words of a file."""
    return set(re.findall(r"\w+", path.read_text()))


def place(path: Path, line: int) -> str:
    """Name a place so that an editor can open it."""
    return f"{path.relative_to(ROOT).as_posix()}:{line}"


def stray_randomness(tree: ast.AST) -> list[int]:
    """Return the lines that draw or make random numbers; naming the Generator type is allowed."""
    lines = []
    called = {id(node.func) for node in ast.walk(tree) if isinstance(node, ast.Call)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names = {alias.name for alias in node.names}
            if any(name.split(".")[0] in ("random", "secrets") for name in names):
                lines.append(node.lineno)
            if "numpy.random" in names:
                lines.append(node.lineno)
        elif isinstance(node, ast.ImportFrom):
            names = {alias.name for alias in node.names}
            if (
                node.module in ("random", "secrets")
                or (node.module == "numpy" and "random" in names)
                or (node.module == "numpy.random" and names != {"Generator"})
            ):
                lines.append(node.lineno)
        elif (
            isinstance(node, ast.Attribute)
            and is_numpy_random(node.value)
            and (node.attr != "Generator" or id(node) in called)
        ):
            lines.append(node.lineno)
    return sorted(lines)


def is_numpy_random(node: ast.AST) -> bool:
    match node:
        case ast.Attribute(ast.Name("np" | "numpy"), "random"):
            return True
    return False


def undocumented(tree: ast.Module) -> dict[str, int]:
    """Return name and line of each public function and class (inner ones, too) without a docstring.

    The module itself, if it has none, is named "the module".
    """
    found = {
        name: node.lineno
        for name, node in public_definitions(tree.body)
        if not ast.get_docstring(node) and not is_overload(node)
    }
    return found if ast.get_docstring(tree) else {"the module": 1, **found}


def public_definitions(body: list[ast.stmt], inside: str = "") -> Iterator[tuple[str, ast.AST]]:
    for node in body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_"):
            name = inside + node.name
            yield name, node
            if isinstance(node, ast.ClassDef):
                inner = [item for item in node.body if isinstance(item, ast.ClassDef)]
                yield from public_definitions(inner, f"{name}.")


def is_overload(node: ast.AST) -> bool:
    return any("overload" in ast.unparse(item) for item in getattr(node, "decorator_list", []))


def test_there_is_something_to_check():
    assert PACKAGE / "seeding.py" in SOURCES


def test_only_seeding_makes_random_numbers():
    found = [
        place(path, line)
        for path in SOURCES
        if path != PACKAGE / "seeding.py" and {"random", "secrets"} & words(path)
        for line in stray_randomness(parsed(path))
    ]
    assert found == []


@pytest.mark.parametrize(
    "text",
    [
        "import random",
        "from random import choice",
        "import numpy.random",
        "from numpy import random",
        "from numpy.random import default_rng",
        "x = np.random.rand(3)",
        "numpy.random.seed(1)",
        "def f():\n    return np.random.default_rng()",
        "g = np.random.Generator(bits)",
    ],
)
def test_the_search_finds_stray_randomness(text):
    assert stray_randomness(ast.parse(text)) != []


def test_the_search_allows_a_generator_as_an_argument():
    text = "from numpy.random import Generator\ndef f(g: np.random.Generator): return g.random()"
    assert stray_randomness(ast.parse(text)) == []


def test_seeding_itself_would_be_found():
    assert stray_randomness(parsed(PACKAGE / "seeding.py")) != []


def test_no_room_is_an_attic():
    found = [
        place(path, 1)
        for path in SOURCES
        if not ATTICS.isdisjoint(path.relative_to(PACKAGE).with_suffix("").parts)
    ]
    assert found == []


def test_every_file_can_be_read_in_one_sitting():
    found = [
        place(path, lines)
        for path in FILES
        if (lines := len(path.read_text().splitlines())) > LONGEST
    ]
    assert found == []


def test_what_is_public_is_documented():
    found = [
        f"{place(path, line)} {name}"
        for path in SOURCES
        for name, line in undocumented(parsed(path)).items()
    ]
    assert found == []


def test_the_search_finds_what_is_not_documented():
    text = "class A:\n    class B:\n        x = 1\ndef f(): pass\ndef _g(): pass"
    assert undocumented(ast.parse(text)) == {"the module": 1, "A": 1, "A.B": 2, "f": 4}


def test_the_search_accepts_what_is_documented():
    text = '"""Docs."""\n@overload\ndef f(): ...\ndef f():\n    """Docs."""'
    assert undocumented(ast.parse(text)) == {}
