"""All tables of a study of memories, computed once for page, figures and command line."""

from __future__ import annotations

from dataclasses import dataclass

import polars as pl

from dmil.results import Results
from dmil.studies.memories.arranged import Arranged, arranged
from dmil.studies.memories.claims import claims
from dmil.studies.memories.cost import cost, hit_rates, learning_curves, memory_courses
from dmil.studies.memories.ranking import ablation, overall, profiles, standing


@dataclass(frozen=True, slots=True)
class MemoriesTables:
    """What is known about a study of memories: see the functions of these names.

    ``failures`` says where runs failed, and what they said.
    """

    runs: Arranged
    standing: pl.DataFrame
    overall: pl.DataFrame
    cost: pl.DataFrame
    hit_rates: pl.DataFrame
    learning: pl.DataFrame
    memory: pl.DataFrame
    profiles: pl.DataFrame
    ablation: pl.DataFrame
    claims: pl.DataFrame
    failures: pl.DataFrame


def memories_tables(results: Results) -> MemoriesTables:
    """Compute all tables of a study of memories (ours).

    Raises
    ------
    InputError
        No run succeeded.
    """
    runs = arranged(results)
    table, costs = standing(runs), cost(runs)
    return MemoriesTables(
        runs,
        table,
        overall(runs),
        costs,
        hit_rates(results),
        learning_curves(results, runs),
        memory_courses(results, runs),
        profiles(runs),
        ablation(runs),
        claims(runs, table, costs),
        results.query(
            "select controller, scenario, load, seed, status from runs where status <> 'ok'"
            " order by all"
        ),
    )
