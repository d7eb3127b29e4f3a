"""Runs of one study on several networks and simulators, arranged for comparison."""

from __future__ import annotations

import re
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import polars as pl
from numpy.typing import NDArray

from dmil.analysis.panel import EMBEDDING_ORDER, check_distinct, check_success, ordered, panel_of
from dmil.results import Results
from dmil.studies.resco.plan import BASELINES, LEARNERS

Values = NDArray[np.float64]

#: Columns that tell contenders apart.
CONTENDER: tuple[str, ...] = ("controller", "embedding", "communication", "reward", "epsilon")

JUDGES = ("sumo", "sumo-meso")
QUEUES = ("queue", "queue-calibrated")
SIMULATOR_ORDER = (*JUDGES, "queue-calibrated", "queue")
REFERENCE = "max-pressure"
CONTROLLER_ORDER = (*BASELINES, *dict.fromkeys(name for name, *_ in LEARNERS))


@dataclass(frozen=True, slots=True)
class RescoContender:
    """A controller with all that its results depend on but network, simulator and seed.

    Attributes
    ----------
    controller: str
    embedding, reward, epsilon
        What it learns with; None for controllers that do not learn.
    communication: bool
        Whether its agents meet the central unit.
    """

    controller: str
    embedding: str | None = None
    communication: bool = False
    reward: str | None = None
    epsilon: float | None = None

    @property
    def learns(self) -> bool:
        """Whether it was trained."""
        return self.reward is not None


def contender_names(contenders: list[RescoContender]) -> list[str]:
    """Return a short name for each, with reward and ε only where they differ (ours)."""
    rewards = {each.reward for each in contenders if each.learns}
    epsilons = {each.epsilon for each in contenders if each.learns}
    names = []
    for each in contenders:
        parts = [each.controller] if each.embedding is None else [each.controller, each.embedding]
        if each.communication:
            parts.append("+ communication")
        if each.learns and len(rewards) > 1:
            parts.append(f"{each.reward} reward")
        if each.learns and len(epsilons) > 1:
            parts.append(f"ε {each.epsilon:g}")
        names.append(" ".join(parts))
    return names


@dataclass(frozen=True)
class Judged:
    """Measures of all successful runs.

    Attributes
    ----------
    contenders: tuple of RescoContender
    names: tuple of str
        Their names.
    scenarios, simulators: tuple of str
    seeds: tuple of int
    trained_in: str or None
        Simulator that the learners were trained in.
    measures: dict
        Numeric column of ``runs`` to (simulators, scenarios, contenders, seeds); NaN where there is
        no run.
    """

    contenders: tuple[RescoContender, ...]
    names: tuple[str, ...]
    scenarios: tuple[str, ...]
    simulators: tuple[str, ...]
    seeds: tuple[int, ...]
    trained_in: str | None
    measures: dict[str, Values]

    @property
    def judge(self) -> str:
        """The simulator that controllers are judged in: SUMO where it ran."""
        return self.simulators[0]

    def of(self, measure: str, simulator: str) -> Values:
        """Return a measure in one simulator, (scenarios, contenders, seeds)."""
        values: Values = self.measures[measure][self.simulators.index(simulator)]
        return values

    def number(self, controller: str) -> int | None:
        """Return the number of a contender that does not learn, None if it was not run."""
        name = RescoContender(controller)
        return self.contenders.index(name) if name in self.contenders else None

    @property
    def keys(self) -> pl.DataFrame:
        """The columns of `CONTENDER` and ``contender``, the name; in order."""
        kinds = {"embedding": pl.String, "reward": pl.String, "epsilon": pl.Float64}
        return pl.DataFrame(
            [asdict(each) for each in self.contenders], schema_overrides=kinds
        ).with_columns(contender=pl.Series(self.names))


def judged(results: Results) -> Judged:
    """Arrange the successful runs of a study (ours).

    Raises
    ------
    InputError
        No run succeeded, or two runs of one contender share network, simulator and seed.
    """
    runs = results.runs()
    check_success(runs, results)
    runs = runs.filter(pl.col("status") == "ok")
    check_distinct(
        runs,
        ("scenario", "simulator", *CONTENDER, "seed"),
        results,
        shared="controller, network, simulator and seed",
        mend="analyse different horizons or trainings in folders of their own",
    )
    rows = runs.select(CONTENDER).unique().iter_rows(named=True)
    contenders = sorted((RescoContender(**row) for row in rows), key=_rank)
    scenarios = sorted(runs["scenario"].unique().to_list(), key=_scenario_rank)
    simulators = ordered(runs["simulator"].unique().to_list(), SIMULATOR_ORDER)
    seeds = sorted(runs["seed"].unique().to_list())
    trained_in = runs["trained_in"].drop_nulls().unique().sort()
    panel = panel_of(
        (simulators, runs["simulator"].to_list()),
        (scenarios, runs["scenario"].to_list()),
        (
            contenders,
            [RescoContender(**row) for row in runs.select(CONTENDER).iter_rows(named=True)],
        ),
        (seeds, runs["seed"].to_list()),
    )
    return Judged(
        contenders=tuple(contenders),
        names=tuple(contender_names(contenders)),
        scenarios=tuple(scenarios),
        simulators=tuple(simulators),
        seeds=tuple(seeds),
        trained_in=", ".join(trained_in) or None,
        measures=panel.measures(runs, but=(*CONTENDER, "seed")),
    )


def _rank(contender: RescoContender) -> tuple[Any, ...]:
    def place(name: str | None, order: tuple[str, ...]) -> tuple[int, str]:
        return (order.index(name) if name in order else len(order), name or "")

    return (
        place(contender.controller, CONTROLLER_ORDER),
        place(contender.embedding, EMBEDDING_ORDER),
        contender.communication,
        contender.reward or "",
        contender.epsilon or 0.0,
    )


def _scenario_rank(name: str) -> tuple[bool, str, int, str]:
    """Real towns before made-up grids, and small ones before large ones."""
    short = name.rpartition("/")[2]
    found = re.fullmatch(r"([a-z]+)(\d+)", short)
    return (found is None, found[1] if found else short, int(found[2]) if found else 0, name)
