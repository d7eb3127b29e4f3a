"""No study knows another one, and the engine knows none."""

import ast
from pathlib import Path

import dmil
from dmil.studies.registry import STUDIES

PACKAGE = Path(dmil.__file__).parent


def imported(path):
    """Return the modules that a file imports, wherever in it."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def test_every_folder_of_studies_is_registered():
    folders = {path.parent.name for path in (PACKAGE / "studies").glob("*/study.py")}
    assert folders == set(STUDIES)


def test_a_study_imports_no_other_study():
    """What two of them need lies below, not beside them."""
    offenders = [
        f"{path.relative_to(PACKAGE)}: {module}"
        for name in STUDIES
        for path in (PACKAGE / "studies" / name).rglob("*.py")
        for module in imported(path)
        if module.startswith("dmil.studies") and not module.startswith(f"dmil.studies.{name}")
    ]
    assert offenders == []
