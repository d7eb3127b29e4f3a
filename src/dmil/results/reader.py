"""Read a folder of results: tables as polars frames, or any question in SQL."""

from __future__ import annotations

import re
from pathlib import Path
from types import SimpleNamespace, TracebackType
from typing import Any

import duckdb
import polars as pl

from dmil.errors import InputError, OutputError
from dmil.results.manifest import read_manifest
from dmil.results.schema import TABLES
from dmil.results.writer import table_file


class Results:
    """A folder of results, checked when it is opened.

    Parameters
    ----------
    folder
        Folder with the files of all tables and ``manifest.json``.

    Raises
    ------
    OutputError
        The folder is not one of results, has another schema version, or a table is damaged.

    Examples
    --------
    >>> results = Results("study")  # doctest: +SKIP
    >>> results.query("select controller, avg(w_over_vc) from runs group by 1")  # doctest: +SKIP
    """

    def __init__(self, folder: Path | str) -> None:
        self.folder = Path(folder)
        self.manifest: dict[str, Any] = read_manifest(self.folder)
        self._connection = duckdb.connect(":memory:")
        for name, table in TABLES.items():
            path = self.folder / table_file(name)
            _check(path, table.schema)
            self._connection.execute(f"create view {name} as from read_parquet({_quoted(path)})")

    def runs(self) -> pl.DataFrame:
        """Return one row per run, columns as in :data:`dmil.results.RUNS_SCHEMA`."""
        return self.query("from runs")

    def series(self) -> pl.DataFrame:
        """Return one row per run and time, columns as in :data:`dmil.results.SERIES_SCHEMA`."""
        return self.query("from series")

    def episodes(self) -> pl.DataFrame:
        """Return one row per training episode, columns as in ``dmil.results.TABLES``."""
        return self.query("from episodes")

    def query(self, sql: str) -> pl.DataFrame:
        """Answer a question in DuckDB's SQL; the tables are its views.

        Raises
        ------
        InputError
            The SQL is wrong, or a table is damaged.
        """
        try:
            answer = self._connection.sql(sql)
            if answer is None:
                raise InputError(
                    "the statement returns no rows", where="query", expected="a select"
                )
            stream = answer.__arrow_c_stream__()
            # polars remembers every type it was given; remembering one of DuckDB's would make the
            # interpreter report leaks when it ends, so the stream is handed over in plain clothes.
            return pl.DataFrame(SimpleNamespace(__arrow_c_stream__=lambda _schema=None: stream))
        except duckdb.Error as error:
            raise InputError(
                str(error).strip(), where=f"query on {self.folder}", expected="SQL of DuckDB"
            ) from error
        except RuntimeError as error:
            if "interrupted" in str(error).lower():  # what DuckDB makes of Ctrl-C
                raise KeyboardInterrupt from error
            raise

    def close(self) -> None:
        """Close the connection."""
        self._connection.close()

    def __enter__(self) -> Results:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def _quoted(path: Path) -> str:
    """Return a path as DuckDB takes it: one file, whatever its name, and never a pattern."""
    literal = re.sub(r"[*?[]", r"[\g<0>]", str(path)).replace("'", "''")
    return f"'{literal}'"


def _check(path: Path, schema: dict[str, pl.DataType]) -> None:
    mend = "run the study again; it resumes where it can"
    if not path.is_file():
        raise OutputError(
            f"it holds no {path.name}",
            where=str(path.parent),
            expected="a finished study",
            mend=mend,
        )
    try:
        found = dict(pl.scan_parquet(path, glob=False).collect_schema())
    except (pl.exceptions.PolarsError, OSError) as error:
        raise OutputError(
            f"the file is truncated or is not Parquet ({error})", where=str(path), mend=mend
        ) from error
    if found != schema:
        names = sorted(
            name for name in found.keys() | schema.keys() if found.get(name) != schema.get(name)
        )
        raise OutputError(
            f"columns {', '.join(names)} are missing, unknown or of another type",
            where=str(path),
            expected="the columns of dmil.results.schema",
            mend=mend,
        )
