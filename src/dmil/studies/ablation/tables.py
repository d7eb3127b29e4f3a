"""All tables of an ablation, computed once for page, figure and command line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import polars as pl
from numpy.typing import NDArray

from dmil.analysis.estimates import IQM, Values, as_column, interval_columns
from dmil.analysis.panel import RunPanel, check_distinct, check_success, on_axes
from dmil.controllers.variants import parse_variant
from dmil.results import Results
from dmil.seeding import stream
from dmil.statistics import Estimate, interquartile_mean, mean_interval
from dmil.studies.ablation.plan import PARTS, Switched

DELAY = "delay_s"
_PLACE = ("scenario", "load", "controller", "seed")


@dataclass(frozen=True, kw_only=True)
class AblationRuns(RunPanel):
    """All successful runs; the axes are ``cell``, ``controller`` (labels) and ``seed``.

    Attributes
    ----------
    switched: tuple of Switched
        What was switched, in the order of the study.
    """

    switched: tuple[Switched, ...]

    @property
    def cells(self) -> Sequence[str]:
        """Names, in the order of the study."""
        return self.axes["cell"]

    @property
    def controllers(self) -> list[str]:
        """Names of the controllers whose parts were switched."""
        return list(dict.fromkeys(each.controller for each in self.switched))

    @property
    def changes(self) -> list[str]:
        """All that was changed, each once, parts in their order."""
        found = {each.change: list(PARTS).index(each.part) for each in self.switched}
        return sorted(found, key=lambda change: (found[change], change))


@dataclass(frozen=True, slots=True)
class AblationTables:
    """What is known about an ablation: see the functions of these names.

    ``locks`` are the runs with intersections that locked, ``failures`` those that failed.
    """

    runs: AblationRuns
    delays: pl.DataFrame
    differences: pl.DataFrame
    locks: pl.DataFrame
    failures: pl.DataFrame


def ablation_tables(results: Results) -> AblationTables:
    """Compute all tables of an ablation (ours).

    Raises
    ------
    InputError
        No run succeeded, or two share controller, case and seed.
    """
    runs = arranged(results)
    return AblationTables(
        runs,
        delays(runs),
        differences(runs),
        results.query(
            "select scenario, load, controller, seed, locked, locked_from_s, delay_s from runs"
            " where locked > 0 order by all"
        ),
        results.query(
            "select controller, scenario, load, seed, status from runs where status <> 'ok'"
            " order by all"
        ),
    )


def arranged(results: Results) -> AblationRuns:
    """Arrange the successful runs of a study by case, controller and seed (ours).

    Raises
    ------
    InputError
        No run succeeded, or two share controller, case and seed.
    """
    runs = results.runs()
    check_success(runs, results)
    mend = "analyse different horizons in folders of their own"
    check_distinct(runs, _PLACE, results, shared="controller, case and seed", mend=mend)
    configuration: Mapping[str, Any] = results.manifest["configuration"]
    of_runs = [_cell(*row) for row in runs.select("scenario", "load").rows()]
    axes = {
        "cell": [name for name in configuration["cells"] if name in of_runs],
        "controller": configuration["variants"],
        "seed": sorted(runs["seed"].unique()),
    }
    array = on_axes(runs, axes, cell=of_runs)
    return AblationRuns(
        axes=axes,
        measures={name: array(name) for name in (DELAY, "locked")},
        switched=tuple(_switched(configuration["variants"])),
    )


def _cell(scenario: str, load: float) -> str:
    return scenario if load == 1.0 else f"{scenario}*{load:g}"


def _switched(labels: Sequence[str]) -> list[Switched]:
    """Return what is switched in the variants of a study, told from their labels."""
    found = []
    for variant in map(parse_variant, labels):
        for option, value in variant.options.items():
            part = next(name for name, each in PARTS.items() if each.option == option)
            added = value == PARTS[part].on
            found.append(Switched(variant.name, part, added, variant))
    return found


def delays(runs: AblationRuns) -> pl.DataFrame:
    """Return the delay of every controller as it is (ours).

    Returns
    -------
    Per cell and controller: ``n`` seeds, the interquartile mean ``delay_s`` with ``low`` and
    ``high``, the ``median``, and ``locked``, the runs in which an intersection locked.
    """
    rows = []
    for cell in runs.cells:
        values = np.stack(
            [runs.of(DELAY, cell=cell, controller=name) for name in runs.controllers], axis=1
        )
        found = mean_interval(values, stream(0, "bootstrap", "ablation", cell), summary=IQM)
        columns: dict[str, object] = {
            "cell": [cell] * len(runs.controllers),
            "controller": runs.controllers,
            "n": found.seeds,
            **interval_columns(found, "delay_s"),
            "median": as_column(_median(values)),
            "locked": [_locked(runs, cell, name) for name in runs.controllers],
        }
        rows.append(pl.DataFrame(columns))
    return pl.concat(rows)


def differences(runs: AblationRuns) -> pl.DataFrame:
    """Return what every switched part changes, on the same vehicles (ours).

    Returns
    -------
    Per cell, controller and part: ``change`` in words, the ``variant`` that ran, ``n`` seeds, the
    interquartile mean of the paired differences in delay ``delay_s`` with ``low`` and ``high``, the
    same in % of the controller as it is, ``pct`` with ``pct_low`` and ``pct_high``, over the
    ``free`` seeds in which neither of the two locked, ``alike``, the share of seeds in which
    nothing changed, and ``locked``, the runs in which an intersection locked.
    """
    rows: list[dict[str, Any]] = []
    for cell in runs.cells:
        for each in runs.switched:
            label = each.variant.label
            names = "bootstrap", "ablation", cell, label
            change = _of(runs, cell, label) - _of(runs, cell, each.controller)
            found = mean_interval(change[:, None], stream(0, *names), summary=IQM)
            free = _free(runs, cell, label) & _free(runs, cell, each.controller)
            usual = np.where(free, _of(runs, cell, each.controller), np.nan)
            percent = mean_interval(
                np.where(free, 100.0 * change / _iqm(usual), np.nan)[:, None],
                stream(0, *names),
                summary=IQM,
            )
            rows.append(
                _who(cell, each)
                | {"n": int(found.seeds[0]), "free": int(percent.seeds[0])}
                | _ends(found, "delay_s", "low", "high")
                | _ends(percent, "pct", "pct_low", "pct_high")
                | {"alike": _share(change), "locked": _locked(runs, cell, label)}
            )
    return pl.DataFrame(rows, schema=_SCHEMA).fill_nan(None)


_SCHEMA: dict[str, type[pl.DataType]] = {
    **dict.fromkeys(("cell", "controller", "part", "change", "variant"), pl.String),
    **dict.fromkeys(("n", "free"), pl.Int64),
    **dict.fromkeys(("delay_s", "low", "high", "pct", "pct_low", "pct_high", "alike"), pl.Float64),
    "locked": pl.Int64,
}


def _who(cell: str, each: Switched) -> dict[str, Any]:
    return {
        "cell": cell,
        "controller": each.controller,
        "part": each.part,
        "change": each.change,
        "variant": each.variant.label,
    }


def _ends(found: Estimate, *names: str) -> dict[str, float]:
    ends = (found.value, found.low, found.high)
    return {name: float(end[0]) for name, end in zip(names, ends, strict=True)}


def _of(runs: AblationRuns, cell: str, label: str) -> Values:
    return runs.of(DELAY, cell=cell, controller=label)


def _free(runs: AblationRuns, cell: str, label: str) -> NDArray[np.bool_]:
    """Return in which seeds no intersection locked."""
    return np.asarray(runs.of("locked", cell=cell, controller=label) == 0)


def _iqm(values: Values) -> float:
    present = values[~np.isnan(values)]
    found = float(interquartile_mean(present)) if present.size else np.nan
    return found if found > 0 else np.nan


def _share(change: Values) -> float:
    present = change[~np.isnan(change)]
    return float((present == 0.0).mean()) if present.size else np.nan


def _median(values: Values) -> Values:
    return np.array(
        [np.median(c[~np.isnan(c)]) if (~np.isnan(c)).any() else np.nan for c in values.T]
    )


def _locked(runs: AblationRuns, cell: str, label: str) -> int:
    return int((runs.of("locked", cell=cell, controller=label) > 0).sum())
