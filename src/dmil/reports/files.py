"""Tables for other programs: CSV."""

from __future__ import annotations

import io

import polars as pl


def csv(table: pl.DataFrame) -> str:
    """Return a table as CSV; lists are left out."""
    flat = table.select(name for name, dtype in table.schema.items() if not dtype.is_nested())
    buffer = io.StringIO()
    flat.write_csv(buffer)
    return buffer.getvalue()
