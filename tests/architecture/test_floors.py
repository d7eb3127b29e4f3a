"""Who may import whom, and what importing the package costs."""

import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
HEAVY = ("altair", "duckdb", "numba", "polars", "ray", "scipy")


def lint_imports(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    program = Path(sysconfig.get_path("scripts")) / "lint-imports"
    command = [str(program), "--no-cache", *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def test_every_room_imports_only_lower_floors():
    done = lint_imports(ROOT)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_check_of_floors_sees_an_import_upwards(tmp_path, monkeypatch):
    package = tmp_path / "dmil"
    package.mkdir()
    for name in ("__init__", "compilation", "errors", "controllers"):
        (package / f"{name}.py").write_text("")
    (package / "seeding.py").write_text("import dmil.controllers\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    done = lint_imports(tmp_path, "--config", str(ROOT / "pyproject.toml"))
    assert done.returncode == 1
    assert "dmil.seeding -> dmil.controllers" in done.stdout


@pytest.mark.parametrize("name", HEAVY)
def test_importing_the_package_is_light(name, modules_after_import):
    assert name not in modules_after_import


@pytest.fixture(scope="module")
def modules_after_import() -> set[str]:
    code = "import sys, dmil; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "dmil" in done.stdout.split()
    return set(done.stdout.split())
