"""Write the tables of a study: whole or not at all, and the same bytes for the same rows."""

from __future__ import annotations

from functools import partial
from itertools import zip_longest
from pathlib import Path

import polars as pl

from dmil.errors import OutputError
from dmil.files import write_atomically
from dmil.results.schema import RECORDINGS, TABLES, Table


def table_file(name: str) -> str:
    """Return the name of a table's file."""
    return f"{name}.parquet"


def write_results(folder: Path | str, *frames: pl.DataFrame) -> None:
    """Write all tables of results into a folder, each in a file of its name.

    Rows are sorted by what identifies them, so the bytes do not depend on the order in which the
    runs finished. Each file appears whole under its name or not at all.

    Parameters
    ----------
    folder
        Folder of the results; made if it is missing.
    frames
        The tables in the order of `dmil.results.TABLES`; those that are left out are empty.

    Raises
    ------
    OutputError
        A column is missing, unknown, of the wrong type or null where it must not be, two rows
        describe the same run, or the folder cannot be written.
    """
    folder = Path(folder)
    tables = {
        name: _conform(pl.DataFrame(schema=table.schema) if frame is None else frame, table, name)
        for (name, table), frame in zip_longest(TABLES.items(), frames)
    }
    for name, made in tables.items():
        write_atomically(folder / table_file(name), partial(_write_parquet, made))


def write_recording(path: Path, name: str, frame: pl.DataFrame) -> None:
    """Write a table of recorded runs as Parquet, or as CSV where the file's name says so (ours).

    Parameters
    ----------
    path
        The file.
    name
        Which of `dmil.results.schema.RECORDINGS`.
    frame
        Its rows, in the order of time.

    Raises
    ------
    OutputError
        A column is missing, unknown or of the wrong type, or the file cannot be written.
    """
    table = _conform(frame, RECORDINGS[name], name)
    as_csv = path.suffix == ".csv"
    write_atomically(path, table.write_csv if as_csv else partial(_write_parquet, table))


def _write_parquet(table: pl.DataFrame, file: Path) -> None:
    # Fixed row groups and compression: the bytes depend on the rows alone.
    table.write_parquet(file, compression="zstd", statistics=True, row_group_size=65_536)


def _conform(frame: pl.DataFrame, table: Table, name: str) -> pl.DataFrame:
    columns, key = table.columns, table.key
    wanted = [column.name for column in columns]
    missing = [column for column in wanted if column not in frame.columns]
    unknown = [column for column in frame.columns if column not in wanted]
    if missing or unknown:
        raise OutputError(
            f"missing columns {missing}, unknown columns {unknown}",
            where=f"table '{name}'",
            expected="the columns of dmil.results.schema",
        )
    try:
        typed = frame.select(pl.col(column.name).cast(column.dtype) for column in columns)
    except pl.exceptions.PolarsError as error:
        raise OutputError(
            f"a column has the wrong type: {error}", where=f"table '{name}'"
        ) from error
    empty = [c.name for c in columns if not c.nullable and typed[c.name].null_count()]
    if empty:
        raise OutputError(f"columns {empty} have null values", where=f"table '{name}'")
    if not key:
        return typed
    ordered = typed.sort(key, nulls_last=False)
    twice = ordered.filter(pl.struct(key).is_duplicated())
    if twice.height:
        raise OutputError(
            f"{twice.height} rows share their identity, first {twice.select(key).row(0)}",
            where=f"table '{name}'",
            expected=f"one row for each {', '.join(key)}",
        )
    return ordered
