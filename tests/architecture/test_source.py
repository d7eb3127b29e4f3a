"""Rules that every source file keeps: one source of randomness, names, length, docstrings."""

import ast
from collections.abc import Iterator
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


def named(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


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
        elif isinstance(node, ast.Attribute):
            path = ast.unparse(node).split(".")
            if path[:-1] in (["np", "random"], ["numpy", "random"]) and (
                path[-1] != "Generator" or id(node) in called
            ):
                lines.append(node.lineno)
    return sorted(lines)


def undocumented(tree: ast.Module) -> list[str]:
    """Return the public functions and classes, and public methods' classes, without a docstring."""
    return [
        name
        for name, node in public_definitions(tree.body)
        if not ast.get_docstring(node) and not is_overload(node)
    ]


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


@pytest.mark.parametrize("path", SOURCES, ids=named)
def test_only_seeding_makes_random_numbers(path):
    if path != PACKAGE / "seeding.py":
        assert stray_randomness(ast.parse(path.read_text())) == []


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
    assert stray_randomness(ast.parse((PACKAGE / "seeding.py").read_text())) != []


@pytest.mark.parametrize("path", SOURCES, ids=named)
def test_no_room_is_an_attic(path):
    assert ATTICS.isdisjoint(path.relative_to(PACKAGE).with_suffix("").parts)


@pytest.mark.parametrize("path", FILES, ids=named)
def test_a_file_can_be_read_in_one_sitting(path):
    assert len(path.read_text().splitlines()) <= LONGEST


@pytest.mark.parametrize("path", SOURCES, ids=named)
def test_what_is_public_is_documented(path):
    tree = ast.parse(path.read_text())
    assert ast.get_docstring(tree), "the module has no docstring"
    assert undocumented(tree) == []


def test_the_search_finds_what_is_not_documented():
    text = "class A:\n    class B:\n        x = 1\ndef f(): pass\ndef _g(): pass"
    assert undocumented(ast.parse(text)) == ["A", "A.B", "f"]
