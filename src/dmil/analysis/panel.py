"""Runs of a study as arrays: one axis for each thing that tells them apart."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import polars as pl
from numpy.typing import NDArray

from dmil.errors import InputError
from dmil.results import Results

Values = NDArray[np.float64]
EMBEDDING_ORDER = ("exact", "simple", "complex", "complex-scaled", "cells")


@dataclass(frozen=True, kw_only=True)
class RunPanel:
    """Measures of runs on named axes.

    Attributes
    ----------
    axes: dict
        Name of each axis to its values, in order; one is ``seed``.
    measures: dict
        Name to an array with these axes; NaN where there is no run.
    """

    axes: Mapping[str, Sequence[Any]]
    measures: Mapping[str, Values]

    @cached_property
    def _numbers(self) -> dict[str, dict[Any, int]]:
        return {axis: _places(values) for axis, values in self.axes.items()}

    @property
    def seeds(self) -> tuple[int, ...]:
        """Seeds, ascending."""
        return tuple(self.axes["seed"])

    def number(self, axis: str, value: Any) -> int | None:
        """Return the place of a value on an axis, None if no run has it."""
        return self._numbers[axis].get(value)

    def of(self, measure: str, **chosen: Any) -> Values:
        """Return a measure at one value of some axes; NaN if no run has it."""
        found: Values = self.measures[measure]
        # From the last axis on: those before it keep their places.
        for dimension, axis in reversed(list(enumerate(self.axes))):
            if axis in chosen:
                number = self.number(axis, chosen[axis])
                taken: Values = np.asarray(found.take(number or 0, axis=dimension))
                found = np.full_like(taken, np.nan) if number is None else taken
        return found


def on_axes(
    runs: pl.DataFrame, axes: Mapping[str, Sequence[Any]], **columns: Sequence[Any]
) -> Callable[..., NDArray[Any]]:
    """Return what arranges a column of runs on axes: ``array(name, missing=nan)``.

    Axes are names to values, in order; ``columns`` has the value of each run on an axis that is no
    column of the runs.
    """
    at = tuple(
        np.array([places[value] for value in columns.get(axis, runs.get_column(axis, default=[]))])
        for axis, places in ((axis, _places(values)) for axis, values in axes.items())
    )

    def array(name: str, missing: float = np.nan) -> NDArray[Any]:
        found = np.full([len(values) for values in axes.values()], float(missing))
        found[at] = runs[name].cast(pl.Float64).fill_null(np.nan).to_numpy()
        return found

    return array


def numeric(runs: pl.DataFrame, but: Collection[str]) -> list[str]:
    """Return the names of all numeric columns, but for those that are named."""
    return [n for n, dtype in runs.schema.items() if dtype.is_numeric() and n not in but]


def _places(values: Sequence[Any]) -> dict[Any, int]:
    return {value: number for number, value in enumerate(values)}


def check_success(runs: pl.DataFrame, results: Results) -> None:
    """Check that some run of a study succeeded; an `InputError` if none did."""
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
    """Check that no two runs stand in the same place, told by some columns; an `InputError` if so.

    ``shared`` is what two runs should not share, such as "cell and seed", ``mend`` what to do.
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


def rows_by(table: pl.DataFrame, *keys: str) -> dict[tuple[Any, ...], dict[str, Any]]:
    """Return the rows of a table by the values of some columns."""
    return {tuple(row[key] for key in keys): row for row in table.iter_rows(named=True)}
