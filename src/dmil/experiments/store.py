"""The folder of a study: finished trials are kept, so that a second start continues."""

from __future__ import annotations

import hashlib
import json
import shutil
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeVar

import polars as pl

from dmil.errors import OutputError
from dmil.experiments.trial import TrialResult, columns_of
from dmil.files import held, write_atomically, write_text_atomically
from dmil.results import TABLES, write_manifest, write_results
from dmil.results.manifest import MANIFEST_FILE

IDENTITY_FILE = "study.json"
PARTS_FOLDER = "parts"
LOCK_FILE = "in-use"
FLUSH_AFTER_S = 5.0
"""Longest time that a finished trial stays in memory only."""
Trial = TypeVar("Trial")


class StudyStore:
    """One study in one folder, made if missing; use it as a context manager.

    The identity is JSON that says what the study is: a folder with another one is refused.

    Raises
    ------
    OutputError
        If the folder is a file, cannot be written, holds something else, or is in use.
    """

    def __init__(self, folder: Path, identity: dict[str, Any]) -> None:
        self.folder = folder
        self.identity = identity
        self._parts = folder / PARTS_FOLDER
        self._waiting: list[TrialResult] = []
        self._flushed_at = time.monotonic()

    def __enter__(self) -> StudyStore:
        self._check()
        self._lock = held(self.folder / LOCK_FILE, where=self.folder, work="study")
        self._lock.__enter__()
        text = json.dumps(self.identity, indent=2, sort_keys=True) + "\n"
        write_text_atomically(self.folder / IDENTITY_FILE, text)
        return self

    def __exit__(self, *exception: object) -> None:
        self.flush()
        self._lock.__exit__(None, None, None)

    @property
    def complete(self) -> bool:
        """Whether the study is finished."""
        return (self.folder / MANIFEST_FILE).is_file()

    def left(self, plan: Sequence[Trial]) -> list[Trial]:
        """Return the trials of a plan that are not kept yet; see `columns_of`."""
        planned = [columns_of(trial) for trial in plan]
        kept: set[tuple[Any, ...]] = set()
        for path in self._part_files("runs") if plan else ():
            kept |= set(_read(path, list(planned[0])).unique().iter_rows())
        return [
            trial
            for trial, columns in zip(plan, planned, strict=True)
            if tuple(columns.values()) not in kept
        ]

    def keep(self, result: TrialResult) -> None:
        """Keep a finished trial; it is on disk within some seconds."""
        self._waiting.append(result)
        if time.monotonic() - self._flushed_at > FLUSH_AFTER_S:
            self.flush()

    def flush(self) -> None:
        """Write the trials that are only in memory."""
        self._flushed_at = time.monotonic()
        if not self._waiting:
            return
        trials = json.dumps([columns_of(result.trial) for result in self._waiting])
        name = hashlib.blake2b(trials.encode(), digest_size=8).hexdigest()
        # The runs last: a trial counts as finished only when all files are there.
        for table in reversed(TABLES):
            rows = [row for result in self._waiting for row in getattr(result, table)]
            frame = pl.DataFrame(rows, schema=TABLES[table].schema)
            write_atomically(self._parts / f"{table}-{name}.parquet", frame.write_parquet)
        self._waiting = []

    def finish(self, manifest: dict[str, Any]) -> None:
        """Join all parts into the tables of results and write the manifest."""
        self.flush()
        names = [path.name.removeprefix("runs-") for path in self._part_files("runs")]
        tables = (
            pl.concat([_read(self._parts / f"{table}-{name}") for name in names])
            for table in TABLES
        )
        write_results(self.folder, *tables)
        write_manifest(self.folder, manifest)
        shutil.rmtree(self._parts)

    def _check(self) -> None:
        if self.folder.exists() and not self.folder.is_dir():
            raise OutputError(
                "it is a file", where=str(self.folder), expected="a folder for the study"
            )
        if not self.folder.is_dir() or not any(self.folder.iterdir()):
            return
        path = self.folder / IDENTITY_FILE
        try:
            found = json.loads(path.read_text(encoding="utf-8"))
        except FileNotFoundError:
            raise OutputError(
                "it holds other files",
                where=str(self.folder),
                expected="an empty folder, or one that holds this study",
                mend="choose another --out",
            ) from None
        except (OSError, ValueError) as error:
            raise OutputError(
                f"cannot be read ({error})", where=str(path), mend="choose another --out"
            ) from None
        wanted = json.loads(json.dumps(self.identity))
        if found != wanted:
            different = _different(found, wanted)
            raise OutputError(
                f"it holds another study, with other {', '.join(different)}",
                where=str(self.folder),
                mend="choose another --out, or give the same options to continue that study",
            )

    def _part_files(self, table: str) -> list[Path]:
        return sorted(self._parts.glob(f"{table}-*.parquet"))


def _read(path: Path, columns: list[str] | None = None) -> pl.DataFrame:
    # Brackets and stars in a folder's name are part of the name, and no pattern.
    return pl.read_parquet(path, columns=columns, glob=False)


def _different(found: Any, wanted: Any, name: str = "") -> list[str]:
    """Return the names of the values in which two pieces of JSON differ."""
    if not (isinstance(found, dict) and isinstance(wanted, dict)):
        return [name] if found != wanted else []
    keys = sorted({*found, *wanted})
    return [each for key in keys for each in _different(found.get(key), wanted.get(key), key)]
