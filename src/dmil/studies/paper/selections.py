"""Which cells a claim compares: one function for each kind of comparison."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import product
from typing import Literal

from dmil.studies.paper.cells import LEARNERS, Cells
from dmil.studies.paper.comparisons import CellComparison
from dmil.studies.paper.published import (
    COMPLEX,
    NO_MEMORY,
    PAPER_COLUMNS,
    SIMPLE,
    PublishedArchitecture,
    intersections_of,
)

WAIT, WAIT_UNDIVIDED, ARRIVED = "w_over_vc", "wait_per_spawned_s", "arrived_veh"
#: Stored states per agent, m_s + m_L; of all agents, what they share counted once; m_L alone; and
#: what is added per decision. For SARSA all of them are m_Q.
ENTRIES, TOTAL_ENTRIES, LONG_ENTRIES = "entries_per_agent", "entries_total", "long_entries"
GROWTH, LONG_GROWTH = "entries_per_decision", "long_entries_per_decision"
PHYSICAL = ("entropy", "diffusion")
ALL_REWARDS = ("default", "entropy", "diffusion")

#: The variants without and with the study's rule of communication.
COMMUNICATION = ("communication=false", "communication=true")

Where = Literal["single", "several", "any"]
"""Grids with one intersection like the paper's, with several, or both."""

Choose = Callable[[Cells, str], Iterator[CellComparison]]


def grids(cells: Cells, which: Where) -> list[str]:
    """Return scenarios with one or with several intersections; unknown networks have several."""
    several = {name: intersections_of(name) != 1 for name in cells.scenarios}
    return [name for name in several if which == "any" or several[name] == (which == "several")]


def columns(
    first: tuple[str, ...],
    second: str,
    measure: str,
    rewards: tuple[str, ...],
    where: Where = "several",
) -> Choose:
    """Compare columns of the paper's table with another column at the same reward."""

    def choose(cells: Cells, preset: str) -> Iterator[CellComparison]:
        for scenario, reward, column in product(grids(cells, where), rewards, first):
            yield CellComparison(
                f"{reward}: {column} against {second}",
                scenario,
                measure,
                cells.find(preset, scenario, reward, cells.reading.architecture(column, preset)),
                cells.find(preset, scenario, reward, cells.reading.architecture(second, preset)),
            )

    return choose


def rewards(
    first: tuple[str, ...],
    second: str,
    measure: str,
    where: Where = "any",
) -> Choose:
    """Compare rewards with another reward in each column of the paper's table."""

    def choose(cells: Cells, preset: str) -> Iterator[CellComparison]:
        for scenario, column, reward in product(grids(cells, where), PAPER_COLUMNS, first):
            architecture = cells.reading.architecture(column, preset)
            yield CellComparison(
                f"{column}: {reward} against {second}",
                scenario,
                measure,
                cells.find(preset, scenario, reward, architecture),
                cells.find(preset, scenario, second, architecture),
            )

    return choose


def complex_against_others(cells: Cells, preset: str) -> Iterator[CellComparison]:
    """Compare what entropy and diffusion gain over default: Complex with the others."""
    several = grids(cells, "several")
    for scenario, reward, other in product(several, PHYSICAL, (NO_MEMORY, SIMPLE)):
        pairs = [
            cells.find(preset, scenario, name, cells.reading.architecture(column, preset))
            for column in (COMPLEX, other)
            for name in (reward, "default")
        ]
        if None not in pairs:
            yield CellComparison(
                f"{reward}/default: Complex against {other}", scenario, WAIT, *pairs
            )


def longer_communication(cells: Cells, preset: str) -> Iterator[CellComparison]:
    """Compare the longer runs of agents that communicate with those of agents that do not."""
    numbers: dict[tuple[str, str], dict[str, int]] = {}
    for number, row in enumerate(cells.table.iter_rows(named=True)):
        if row["preset"] == preset and row["variant"] in COMMUNICATION:
            where = (row["scenario"], row["reward"])
            numbers.setdefault(where, {})[row["variant"]] = number
    for (scenario, reward), found in numbers.items():
        without, with_it = (found.get(variant) for variant in COMMUNICATION)
        label = f"{reward}: Complex + communication against Complex, longer runs"
        yield CellComparison(label, scenario, WAIT_UNDIVIDED, with_it, without)


def against_no_memory(measure: str) -> Choose:
    """Compare Simple and Complex with No Memory, where that is not exact SARSA anyway."""

    def choose(cells: Cells, preset: str) -> Iterator[CellComparison]:
        if cells.reading.architecture(NO_MEMORY, preset).embedding != "exact":
            yield from columns((SIMPLE, COMPLEX), NO_MEMORY, measure, ALL_REWARDS)(cells, preset)

    return choose


def against_exact_sarsa(
    measure: str,
    first: tuple[str, ...] = (SIMPLE, COMPLEX),
    rewards: tuple[str, ...] = ALL_REWARDS,
) -> Choose:
    """Compare columns of the paper's table with SARSA on exact states at its ε."""

    def choose(cells: Cells, preset: str) -> Iterator[CellComparison]:
        table = PublishedArchitecture("sarsa", "exact", False, cells.reading.epsilon_non_memory)
        several = grids(cells, "several")
        for scenario, reward, column in product(several, rewards, first):
            yield CellComparison(
                f"{reward}: {column} against exact SARSA",
                scenario,
                measure,
                cells.find(preset, scenario, reward, cells.reading.architecture(column, preset)),
                cells.find(preset, scenario, reward, table),
            )

    return choose


def at_equal_epsilon(
    first: str, second: str, rewards: tuple[str, ...], measure: str = WAIT
) -> Choose:
    """Compare a controller on the classes with SARSA on "exact" or on the same classes."""

    def choose(cells: Cells, preset: str) -> Iterator[CellComparison]:
        several = grids(cells, "several")
        classes = ("simple", cells.reading.complex_embedding)
        for scenario, reward, embedding in product(several, rewards, classes):
            other = "exact" if second == "exact" else embedding
            epsilon = cells.reading.epsilon_memory
            yield CellComparison(
                f"{reward}: {first} {embedding} against sarsa {other}, ε = {epsilon}",
                scenario,
                measure,
                cells.find(
                    preset,
                    scenario,
                    reward,
                    PublishedArchitecture(first, embedding, False, epsilon),
                ),
                cells.find(
                    preset, scenario, reward, PublishedArchitecture("sarsa", other, False, epsilon)
                ),
            )

    return choose


def learners_against_baselines(cells: Cells, preset: str) -> Iterator[CellComparison]:
    """Compare every learning cell with longest queue first and with max-pressure."""
    for number, row in enumerate(cells.table.iter_rows(named=True)):
        if row["preset"] != preset or row["controller"] not in LEARNERS or row["variant"]:
            continue
        shared = " + communication" if row["communication"] else ""
        name = f"{row['controller']} {row['embedding']}{shared}, {row['reward']}"
        for baseline in ("longest-queue-first", "max-pressure"):
            yield CellComparison(
                f"{name}, ε = {row['epsilon']} against {baseline}",
                row["scenario"],
                WAIT,
                number,
                cells.baseline(preset, row["scenario"], baseline),
            )
