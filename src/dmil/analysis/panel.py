"""Runs of a study as arrays: one axis for each column that tells them apart."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import polars as pl
from numpy.typing import NDArray

from dmil.errors import InputError
from dmil.results import Results

Values = NDArray[np.float64]
EMBEDDING_ORDER = ("exact", "simple", "complex", "complex-scaled", "cells")


@dataclass(frozen=True)
class Panel:
    """Where each run stands on the axes.

    Attributes
    ----------
    shape: tuple of int
        Length of each axis.
    at: tuple of (runs,) int64 arrays
        Place of each run on each axis.
    """

    shape: tuple[int, ...]
    at: tuple[NDArray[np.int64], ...]

    def values(self, column: pl.Series) -> Values:
        """Return a column of the runs as an array of the panel's shape; NaN where there is none."""
        found = np.full(self.shape, np.nan)
        found[self.at] = column.cast(pl.Float64).fill_null(np.nan).to_numpy()
        return found

    def flags(self, column: pl.Series) -> NDArray[np.bool_]:
        """Return a column of bool as an array of the panel's shape; false where there is no run."""
        found = np.zeros(self.shape, np.bool_)
        found[self.at] = column.to_numpy()
        return found

    def measures(self, runs: pl.DataFrame, but: Collection[str]) -> dict[str, Values]:
        """Return all numeric columns of the runs, but for those that are named."""
        return {
            name: self.values(runs[name])
            for name, dtype in runs.schema.items()
            if dtype.is_numeric() and name not in but
        }


def panel_of(*axes: tuple[Sequence[Hashable], Sequence[Hashable]]) -> Panel:
    """Place runs on axes.

    Parameters
    ----------
    axes
        For each axis its values in order, and the value of each run.
    """
    at = []
    for values, column in axes:
        position: Mapping[Any, int] = {value: number for number, value in enumerate(values)}
        at.append(np.array([position[value] for value in column], np.int64))
    return Panel(tuple(len(values) for values, _ in axes), tuple(at))


def check_success(runs: pl.DataFrame, results: Results) -> None:
    """Check that some run of a study succeeded.

    Parameters
    ----------
    runs
        All runs.
    results
        Where they are from.

    Raises
    ------
    InputError
        None did.
    """
    if (runs["status"] == "ok").any():
        return
    reason = f"; the first failed with: {runs['status'][0]}" if runs.height else ""
    raise InputError(
        f"the study has no successful run{reason}",
        where=str(results.folder),
        mend="run 'dmil study' again",
    )


def check_distinct(
    runs: pl.DataFrame, place: Sequence[str], results: Results, *, shared: str, mend: str
) -> None:
    """Check that no two runs stand in the same place.

    Parameters
    ----------
    runs
        Rows with the columns of ``place``.
    place
        Columns that tell runs apart.
    results
        Where they are from.
    shared, mend
        What two runs should not share, such as "cell and seed"; what to do about it.

    Raises
    ------
    InputError
        Two do.
    """
    twice = runs.filter(pl.struct(place).is_duplicated())
    if twice.height:
        raise InputError(
            f"{twice.height} runs share {shared}, first {twice.select(place).row(0)}",
            where=str(results.folder),
            expected="one run for each",
            mend=mend,
        )


def ordered(names: Sequence[str], order: Sequence[str]) -> list[str]:
    """Return names in a given order, unknown ones after them by the alphabet."""
    rank = {name: number for number, name in enumerate(order)}
    return sorted(names, key=lambda name: (rank.get(name, len(rank)), name))
