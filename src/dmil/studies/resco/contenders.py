"""Runs of one study on several networks and simulators, arranged for comparison."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import polars as pl

from dmil.analysis.panel import (
    EMBEDDING_ORDER,
    RunPanel,
    check_distinct,
    check_success,
    numeric,
    on_axes,
    ordered,
)
from dmil.results import Results
from dmil.studies.resco.plan import DEEP, LEARNERS, UNTRAINED
from dmil.studies.resco.settings import UNBLOCKED

#: Columns that tell contenders apart.
CONTENDER: tuple[str, ...] = ("controller", "embedding", "communication", "reward", "epsilon")

JUDGES = ("sumo", "sumo-meso", UNBLOCKED)
QUEUES = ("queue", "queue-calibrated")
SIMULATOR_ORDER = (*JUDGES, "queue-calibrated", "queue")
REFERENCE = "max-pressure"
CONTROLLER_ORDER = (
    *(each.label for each in UNTRAINED),
    *dict.fromkeys(name for name, *_ in LEARNERS),
    DEEP,
)


@dataclass(frozen=True, slots=True)
class RescoContender:
    """A controller with all that its results depend on but network, simulator and seed.

    Embedding, reward and ε are None for controllers that do not learn.
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


def contender_names(contenders: Sequence[RescoContender]) -> list[str]:
    """Return a short name for each, with reward and ε only where a controller has several."""
    names = []
    for each in contenders:
        alike = [one for one in contenders if one.controller == each.controller and one.learns]
        rewards, epsilons = ({getattr(one, of) for one in alike} for of in ("reward", "epsilon"))
        parts = [each.controller] if each.embedding is None else [each.controller, each.embedding]
        if each.communication:
            parts.append("+ communication")
        if each.learns and len(rewards) > 1:
            parts.append(f"{each.reward} reward")
        if each.learns and len(epsilons) > 1:
            parts.append(f"ε {each.epsilon:g}")
        names.append(" ".join(parts))
    return names


@dataclass(frozen=True, kw_only=True)
class Judged(RunPanel):
    """All successful runs; the axes are ``simulator``, ``scenario``, ``contender`` and ``seed``.

    ``names`` are those of the contenders, ``trained_in`` the simulators that learners trained in.
    """

    names: tuple[str, ...]
    trained_in: tuple[str, ...]

    @property
    def contenders(self) -> Sequence[RescoContender]:
        """Who was judged."""
        return self.axes["contender"]

    @property
    def scenarios(self) -> Sequence[str]:
        """Networks, real towns first."""
        return self.axes["scenario"]

    @property
    def simulators(self) -> Sequence[str]:
        """Simulators, the judge first."""
        return self.axes["simulator"]

    @property
    def judge(self) -> str:
        """The simulator that controllers are judged in: SUMO where it ran."""
        return self.simulators[0]

    @property
    def reference(self) -> int | None:
        """The number of max-pressure, None if it was not run."""
        return self.number("contender", RescoContender(REFERENCE))

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
    who = [RescoContender(*row) for row in runs.select(CONTENDER).rows()]
    axes = {
        "simulator": ordered(runs["simulator"].unique().to_list(), SIMULATOR_ORDER),
        "scenario": sorted(runs["scenario"].unique(), key=_scenario_rank),
        "contender": sorted(set(who), key=_rank),
        "seed": sorted(runs["seed"].unique()),
    }
    array = on_axes(runs, axes, contender=who)
    return Judged(
        axes=axes,
        measures={name: array(name) for name in numeric(runs, but=(*CONTENDER, "seed"))},
        names=tuple(contender_names(axes["contender"])),
        trained_in=tuple(runs["trained_in"].drop_nulls().unique().sort()),
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
