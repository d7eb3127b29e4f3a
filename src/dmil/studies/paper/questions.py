"""How the claims of the paper are written down, and which cells a question compares."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import product
from typing import Literal

from dmil.analysis.claims import Claim, Question, Relation
from dmil.studies.paper.cells import LEARNERS, CellComparison, Cells
from dmil.studies.paper.plan import Architecture
from dmil.studies.paper.published import (
    COMPLEX,
    NO_MEMORY,
    PAPER_COLUMNS,
    SIMPLE,
    Reading,
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
Pairs = list[tuple[str, Architecture, Architecture]]
"""Label, and the agents that are compared."""


def grids(cells: Cells, which: Where) -> list[str]:
    """Return scenarios with one or with several intersections; unknown networks have several."""
    several = {name: intersections_of(name) != 1 for name in cells.scenarios}
    return [name for name in several if which == "any" or several[name] == (which == "several")]


def _compared(
    measure: str,
    where: Where,
    rewards: tuple[str, ...],
    pairs: Callable[[Reading, str], Pairs],
) -> Choose:
    """Compare agents with others at the same reward; each pair has a label."""

    def choose(cells: Cells, preset: str) -> Iterator[CellComparison]:
        found = pairs(cells.reading, preset)
        for scenario, reward, (label, *both) in product(grids(cells, where), rewards, found):
            numbers = [cells.find(preset, scenario, reward, each) for each in both]
            yield CellComparison(f"{reward}: {label}", scenario, measure, *numbers)

    return choose


def columns(
    first: tuple[str, ...],
    second: str,
    measure: str,
    rewards: tuple[str, ...],
    where: Where = "several",
) -> Choose:
    """Compare columns of the paper's table with another column at the same reward."""

    def pairs(reading: Reading, preset: str) -> Pairs:
        known = {name: reading.architecture(name, preset) for name in (*first, second)}
        return [(f"{name} against {second}", known[name], known[second]) for name in first]

    return _compared(measure, where, rewards, pairs)


def rewards(
    first: tuple[str, ...],
    second: str,
    measure: str,
    where: Where = "any",
) -> Choose:
    """Compare rewards with another reward in each column of the paper's table."""

    def choose(cells: Cells, preset: str) -> Iterator[CellComparison]:
        for scenario, column, reward in product(grids(cells, where), PAPER_COLUMNS, first):
            label = f"{column}: {reward} against {second}"
            both = [cells.of_column(preset, scenario, each, column) for each in (reward, second)]
            yield CellComparison(label, scenario, measure, *both)

    return choose


def complex_against_others(cells: Cells, preset: str) -> Iterator[CellComparison]:
    """Compare what entropy and diffusion gain over default: Complex with the others."""
    several = grids(cells, "several")
    for scenario, reward, other in product(several, PHYSICAL, (NO_MEMORY, SIMPLE)):
        pairs = [
            cells.of_column(preset, scenario, name, column)
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

    def pairs(reading: Reading, preset: str) -> Pairs:
        known = {name: reading.architecture(name, preset) for name in first}
        return [(f"{name} against exact SARSA", known[name], reading.exact_sarsa) for name in first]

    return _compared(measure, "several", rewards, pairs)


def at_equal_epsilon(
    first: str, second: str, rewards: tuple[str, ...], measure: str = WAIT
) -> Choose:
    """Compare a controller on the classes with SARSA on "exact" or on the same classes."""

    def pairs(reading: Reading, _: str) -> Pairs:
        epsilon, found = reading.epsilon_memory, []
        for embedding in ("simple", reading.complex_embedding):
            other = "exact" if second == "exact" else embedding
            label = f"{first} {embedding} against sarsa {other}, ε = {epsilon}"
            both = ((first, embedding), ("sarsa", other))
            one, another = (Architecture(*each, epsilon=epsilon) for each in both)
            found.append((label, one, another))
        return found

    return _compared(measure, "several", rewards, pairs)


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


#: Two things count as the same if the interval of their relative difference lies within ±5 %, and
#: an expense is little, or tiny, if the whole interval lies below +5 %.
SAME_WITHIN = 0.05

#: Less than this is no reduction of memory: an interval around 0 then refutes one.
NOTICEABLE = 0.01

PaperClaim = Claim[Choose]
"""Its kind is quotation (the paper's own words), table (numbers of its tables) or ours."""


def claim(
    name: str,
    sentence: str,
    *questions: Question[Choose],
    place: str = "§VI-D",
    kind: str = "quotation",
    note: str = "",
) -> PaperClaim:
    """Return a claim of the paper, by default a quotation of the section with its results."""
    return Claim(name, kind, sentence, questions, place, note)


def by_reward(
    text: str,
    choose: Callable[[tuple[str, ...]], Choose],
    relation: Relation,
    threshold: float = 0.0,
) -> list[Question[Choose]]:
    """Ask for each of the rewards that a sentence does not tell apart, and that differ."""
    return [
        Question(f"{text} {label}", choose(rewards), relation, threshold, label=label)
        for label, rewards in (
            ("under entropy and diffusion", PHYSICAL),
            ("under default", ("default",)),
        )
    ]


def percent(part: float) -> str:
    """Return "5 %" for 0.05 (ours)."""
    return f"{100 * part:.0f} %"
