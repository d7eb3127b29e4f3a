"""In how many runs junctions locked, and how sure that is."""

from __future__ import annotations

import numpy as np
import polars as pl

from dmil.analysis.estimates import as_column, interval_columns
from dmil.statistics import share_interval
from dmil.studies.resco.contenders import JUDGES, Judged

_NO_LOCKS = {
    "scenario": pl.String,
    "simulator": pl.String,
    "contender": pl.String,
    "n": pl.Int64,
    "locked": pl.Int64,
    **dict.fromkeys(("share", "low", "high", "from_s"), pl.Float64),
}


def locks(runs: Judged) -> pl.DataFrame:
    """Return in how many runs of SUMO junctions locked, under every controller (ours).

    What a lock is, see `dmil.training.flow.locks_of`. Means over seeds hide them: a lock is rare,
    and costs as much as all that controllers differ by otherwise.

    Returns
    -------
    Per network, protocol in SUMO and contender: ``n`` runs, those ``locked``, their ``share`` with
    ``low`` and ``high`` (95 %, Wilson), and ``from_s``, the earliest second of a lock (null for
    none). Without runs in which locks were looked for it is empty.
    """
    frames = [pl.DataFrame(schema=_NO_LOCKS)]
    for simulator in runs.simulators:
        if simulator not in JUDGES or "locked" not in runs.measures:
            continue
        junctions = runs.of("locked", simulator=simulator)
        from_s = runs.of("locked_from_s", simulator=simulator)
        for place, scenario in enumerate(runs.scenarios):
            known = ~np.isnan(junctions[place])
            locked = (junctions[place] > 0).sum(axis=1)
            earliest = np.where(np.isnan(from_s[place]), np.inf, from_s[place]).min(axis=1)
            columns = {
                "scenario": [scenario] * len(runs.names),
                "simulator": [simulator] * len(runs.names),
                "contender": list(runs.names),
                "n": known.sum(axis=1),
                "locked": locked,
                **interval_columns(share_interval(locked, known.sum(axis=1)), "share"),
                "from_s": as_column(np.where(np.isinf(earliest), np.nan, earliest)),
            }
            frames.append(pl.DataFrame(columns, schema=_NO_LOCKS).filter(pl.col("n") > 0))
    return pl.concat(frames)
