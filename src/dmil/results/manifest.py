"""What a study was: configuration, versions, command and machine, as one JSON file."""

from __future__ import annotations

import json
import os
import platform
import shlex
import subprocess
import sys
from collections.abc import Mapping
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any

from dmil.errors import OutputError
from dmil.files import write_text_atomically
from dmil.results.schema import SCHEMA_VERSION
from dmil.version import __version__

MANIFEST_FILE = "manifest.json"


def write_manifest(folder: Path | str, manifest: Mapping[str, Any]) -> None:
    """Write ``manifest.json``.

    What :func:`provenance` knows is added; entries of ``manifest`` win over it. A study should give
    ``configuration``, ``started`` and ``finished`` (ISO 8601) and ``wall_s``.

    Parameters
    ----------
    folder
        Folder of the results; made if it is missing.
    manifest
        Values that JSON can hold.

    Raises
    ------
    OutputError
        A value is not JSON, or the folder cannot be written.
    """
    path = Path(folder) / MANIFEST_FILE
    try:
        text = json.dumps({**provenance(), **manifest}, indent=2, allow_nan=False) + "\n"
    except (TypeError, ValueError) as error:
        raise OutputError(
            f"a value cannot be written as JSON ({error})", where=str(path)
        ) from error
    write_text_atomically(path, text)


def read_manifest(folder: Path | str) -> dict[str, Any]:
    """Read and check ``manifest.json``.

    Raises
    ------
    OutputError
        The folder is not one of results, or has another schema version.
    """
    folder = Path(folder)
    path = folder / MANIFEST_FILE
    if not folder.is_dir():
        raise OutputError(
            "there is no such folder", where=str(folder), mend="run 'dmil study' first to make one"
        )
    if not path.is_file():
        raise OutputError(
            f"it holds no {MANIFEST_FILE}",
            where=str(folder),
            expected="a finished folder of results, as 'dmil study' writes it",
        )
    try:
        manifest = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise OutputError(f"cannot be read ({error})", where=str(path)) from error
    found = manifest.get("schema_version") if isinstance(manifest, dict) else None
    if found != SCHEMA_VERSION:
        raise OutputError(
            f"the schema version is {found!r}",
            where=str(path),
            expected=str(SCHEMA_VERSION),
            mend="run the study again, or read it with the version of dmil that wrote it",
        )
    return dict(manifest)


def provenance() -> dict[str, Any]:
    """Return schema version, versions of what computed it, command line and machine."""
    return {
        "schema_version": SCHEMA_VERSION,
        "versions": {
            "dmil": __version__,
            "python": platform.python_version(),
            "numpy": metadata.version("numpy"),
            "numba": metadata.version("numba"),
        },
        "git_commit": _git_commit(),
        "command": shlex.join([Path(sys.argv[0]).name, *sys.argv[1:]]),
        "machine": {
            "cores": len(os.sched_getaffinity(0))
            if hasattr(os, "sched_getaffinity")
            else os.cpu_count(),
            "platform": platform.platform(),
        },
    }


@cache
def _git_commit() -> str | None:
    """Return the commit of the running source, "+" if it was changed since, None outside git."""
    package = Path(__file__).parents[1]

    def git(*arguments: str) -> str:
        command = ["git", "-C", str(package), *arguments]
        result = subprocess.run(command, capture_output=True, text=True, check=True, timeout=10)
        return result.stdout.strip()

    try:
        # An installed copy may lie inside somebody else's repository; only a tracked file counts.
        git("ls-files", "--error-unmatch", "__init__.py")
        return git("rev-parse", "HEAD") + ("+" if git("status", "--porcelain", "--", ".") else "")
    except (OSError, subprocess.SubprocessError):
        return None
