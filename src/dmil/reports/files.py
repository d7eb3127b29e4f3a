"""Tables for other programs and other papers: CSV and LaTeX."""

from __future__ import annotations

import io
from collections.abc import Iterable, Sequence

import polars as pl


def csv(table: pl.DataFrame) -> str:
    """Return a table as CSV; lists are left out."""
    flat = table.select(name for name, dtype in table.schema.items() if not dtype.is_nested())
    buffer = io.StringIO()
    flat.write_csv(buffer)
    return buffer.getvalue()


def evidence_csv(claims: pl.DataFrame) -> str:
    """Return the evidence of all claims, one comparison a row."""
    keys = [name for name in ("preset", "id") if name in claims.columns]
    table = claims.select(*keys, "evidence").explode("evidence").drop_nulls("evidence")
    return csv(table.unnest("evidence"))


def latex(
    notes: Sequence[str],
    head: Sequence[str],
    *parts: Iterable[Sequence[str]],
    left: int = 1,
) -> str:
    r"""Return a LaTeX tabular, for booktabs.

    Parameters
    ----------
    notes
        Comments above it.
    head, parts
        Its first line; its other lines, with a rule before each part that has some.
    left
        Columns that are set flush left.
    """
    lines = [f"% {note}" for note in notes]
    lines += [
        r"\begin{tabular}{" + "l" * left + "r" * (len(head) - left) + "}",
        r"\toprule",
        _line(head),
    ]
    for part in parts:
        rows = [_line(row) for row in part]
        lines += [r"\midrule", *rows] if rows else []
    return "\n".join([*lines, r"\bottomrule", r"\end{tabular}", ""])


def _line(cells: Sequence[str]) -> str:
    return " & ".join(cells) + r" \\"
