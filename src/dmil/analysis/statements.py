"""What is claimed, by the paper and by us, and which comparisons decide it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product
from typing import Literal

from dmil.analysis.cells import LEARNERS, Cells
from dmil.analysis.comparisons import Comparison, Relation
from dmil.analysis.paper import (
    COMPLEX,
    COMPLEX_COMMUNICATION,
    EPSILON_MEMORY,
    EPSILON_NON_MEMORY,
    NO_MEMORY,
    PAPER_COLUMNS,
    SIMPLE,
    Architecture,
    architecture_of,
    intersections_of,
)

WAIT, ARRIVED, ENTRIES, GROWTH = (
    "w_over_vc",
    "arrived_veh",
    "entries_per_agent",
    "entries_per_decision",
)
PHYSICAL = ("entropy", "diffusion")
ALL_REWARDS = ("default", "entropy", "diffusion")

#: Two things count as the same if the interval of their relative difference lies within ±5 %.
SAME_WITHIN = 0.05

Choose = Callable[[Cells, str], Iterator[Comparison]]


@dataclass(frozen=True, slots=True)
class Statement:
    """One claim and its rule.

    Parameters
    ----------
    name
        Short identifier.
    source
        "paper" or "ours".
    sentence
        The paper's words, or ours.
    question
        What is compared, in one line.
    choose
        Yields the comparisons for one preset.
    relation, threshold
        What each comparison has to show.
    quantifier
        Whether all comparisons have to show it or one is enough.
    """

    name: str
    source: Literal["paper", "ours"]
    sentence: str
    question: str
    choose: Choose
    relation: Relation
    threshold: float = 0.0
    quantifier: Literal["all", "any"] = "all"


def grids(cells: Cells, which: Literal["single", "several", "any"]) -> list[str]:
    """Return scenarios with one or with several intersections; unknown networks have several."""
    several = {name: intersections_of(name) != 1 for name in cells.scenarios}
    return [name for name in several if which == "any" or several[name] == (which == "several")]


def columns(
    first: tuple[str, ...],
    second: str,
    measure: str,
    rewards: tuple[str, ...],
    where: Literal["single", "several", "any"] = "several",
) -> Choose:
    """Compare columns of the paper's table with another column at the same reward."""

    def choose(cells: Cells, preset: str) -> Iterator[Comparison]:
        for scenario, reward, column in product(grids(cells, where), rewards, first):
            yield Comparison(
                f"{reward}: {column} against {second}",
                scenario,
                measure,
                cells.find(preset, scenario, reward, architecture_of(column, preset)),
                cells.find(preset, scenario, reward, architecture_of(second, preset)),
            )

    return choose


def rewards(
    first: tuple[str, ...],
    second: str,
    measure: str,
    where: Literal["single", "several", "any"] = "any",
) -> Choose:
    """Compare rewards with another reward in each column of the paper's table."""

    def choose(cells: Cells, preset: str) -> Iterator[Comparison]:
        for scenario, column, reward in product(grids(cells, where), PAPER_COLUMNS, first):
            architecture = architecture_of(column, preset)
            yield Comparison(
                f"{column}: {reward} against {second}",
                scenario,
                measure,
                cells.find(preset, scenario, reward, architecture),
                cells.find(preset, scenario, second, architecture),
            )

    return choose


def _complex_gains_most(cells: Cells, preset: str) -> Iterator[Comparison]:
    several = grids(cells, "several")
    for scenario, reward, other in product(several, PHYSICAL, (NO_MEMORY, SIMPLE)):
        pairs = [
            cells.find(preset, scenario, name, architecture_of(column, preset))
            for column in (COMPLEX, other)
            for name in (reward, "default")
        ]
        if None not in pairs:
            yield Comparison(f"{reward}/default: Complex against {other}", scenario, WAIT, *pairs)


def _against_exact_sarsa(measure: str) -> Choose:
    table = Architecture("sarsa", "exact", False, EPSILON_NON_MEMORY)

    def choose(cells: Cells, preset: str) -> Iterator[Comparison]:
        several = grids(cells, "several")
        for scenario, reward, column in product(several, ALL_REWARDS, (SIMPLE, COMPLEX)):
            yield Comparison(
                f"{reward}: {column} against exact SARSA",
                scenario,
                measure,
                cells.find(preset, scenario, reward, architecture_of(column, preset)),
                cells.find(preset, scenario, reward, table),
            )

    return choose


def _at_equal_epsilon(first: str, second: str) -> Choose:
    """Compare a controller on the classes with SARSA on "exact" or on the same classes."""

    def choose(cells: Cells, preset: str) -> Iterator[Comparison]:
        several = grids(cells, "several")
        for scenario, reward, embedding in product(several, PHYSICAL, ("simple", "complex")):
            other = "exact" if second == "exact" else embedding
            yield Comparison(
                f"{reward}: {first} {embedding} against sarsa {other}, ε = {EPSILON_MEMORY}",
                scenario,
                WAIT,
                cells.find(
                    preset, scenario, reward, Architecture(first, embedding, False, EPSILON_MEMORY)
                ),
                cells.find(
                    preset, scenario, reward, Architecture("sarsa", other, False, EPSILON_MEMORY)
                ),
            )

    return choose


def _learners_against_baselines(cells: Cells, preset: str) -> Iterator[Comparison]:
    for number, row in enumerate(cells.table.iter_rows(named=True)):
        if row["preset"] != preset or row["controller"] not in LEARNERS:
            continue
        shared = " + communication" if row["communication"] else ""
        name = f"{row['controller']} {row['embedding']}{shared}, {row['reward']}"
        for baseline in ("longest-queue-first", "max-pressure"):
            yield Comparison(
                f"{name}, ε = {row['epsilon']} against {baseline}",
                row["scenario"],
                WAIT,
                number,
                cells.baseline(preset, row["scenario"], baseline),
            )


STATEMENTS: tuple[Statement, ...] = (
    Statement(
        "reward-effect",
        "paper",
        "The performance of intersection control can be enhanced further if different reward "
        "functions are used.",
        "W/V_c under entropy and diffusion is below that under default",
        rewards(PHYSICAL, "default", WAIT),
        "below",
    ),
    Statement(
        "memory-beats-sarsa",
        "paper",
        "For both the 3×3 and 5×5 networks, memory-based agents perform better than the SARSA "
        "agents (entropy and diffusion).",
        "W/V_c of Simple and Complex is below No Memory, grids of several intersections",
        columns((SIMPLE, COMPLEX), NO_MEMORY, WAIT, PHYSICAL),
        "below",
    ),
    Statement(
        "simple-wins-default",
        "paper",
        "Table II, 3×3 and 5×5, default: Simple .16, .16; No Memory .19, .17.",
        "W/V_c of Simple is below No Memory under default",
        columns((SIMPLE,), NO_MEMORY, WAIT, ("default",)),
        "below",
    ),
    Statement(
        "complex-loses-default",
        "paper",
        "Table II, 3×3 and 5×5, default: Complex .24, .26; No Memory .19, .17.",
        "W/V_c of Complex is above No Memory under default",
        columns((COMPLEX,), NO_MEMORY, WAIT, ("default",)),
        "above",
    ),
    Statement(
        "single-intersection",
        "paper",
        "In the single-intersection case, the dual-memory agent has a longer average waiting time "
        "than the SARSA agent.",
        "W/V_c of Simple and Complex is above No Memory at one intersection, all rewards",
        columns((SIMPLE, COMPLEX), NO_MEMORY, WAIT, ALL_REWARDS, "single"),
        "above",
    ),
    Statement(
        "complex-gains-most",
        "paper",
        "The largest improvement from different reward functions occurs in the memory with the "
        "complex equivalence embedding.",
        "The ratio of W/V_c to that under default is lower for Complex than for Simple and No "
        "Memory",
        _complex_gains_most,
        "below",
    ),
    Statement(
        "rewards-alike",
        "paper",
        "Entropy and diffusion reward yield nearly identical V_c performance.",
        f"V_c under entropy is within ±{SAME_WITHIN:.0%} of that under diffusion",
        rewards(("entropy",), "diffusion", ARRIVED, "several"),
        "within",
        SAME_WITHIN,
    ),
    Statement(
        "waiting-30",
        "paper",
        "Using entropy and diffusion decreased W up to 30%.",
        "Some architecture waits at least 30 % less (W/V_c) than under default",
        rewards(PHYSICAL, "default", WAIT),
        "below",
        -0.30,
        "any",
    ),
    Statement(
        "throughput-100",
        "paper",
        "… and increased the vehicle throughput by more than 100%.",
        "Some architecture has more than twice the V_c that it has under default",
        rewards(PHYSICAL, "default", ARRIVED, "several"),
        "above",
        1.0,
        "any",
    ),
    Statement(
        "communication-raises-default",
        "paper",
        "Introducing communication often increased waiting times in the 3×3 and 5×5 grid settings "
        "with the default reward function.",
        "W/V_c of Complex + communication is above Complex under default",
        columns((COMPLEX_COMMUNICATION,), COMPLEX, WAIT, ("default",)),
        "above",
    ),
    Statement(
        "communication-no-gain-default",
        "paper",
        "Communication does not necessarily improve global optimality.",
        "W/V_c of Complex + communication is not below Complex under default",
        columns((COMPLEX_COMMUNICATION,), COMPLEX, WAIT, ("default",)),
        "not below",
    ),
    Statement(
        "communication-neutral",
        "paper",
        "This phenomenon doesn't occur with the other two reward signals.",
        f"W/V_c of Complex + communication is within ±{SAME_WITHIN:.0%} of Complex under entropy "
        "and diffusion",
        columns((COMPLEX_COMMUNICATION,), COMPLEX, WAIT, PHYSICAL),
        "within",
        SAME_WITHIN,
    ),
    Statement(
        "memory-flatter",
        "paper",
        "Unlike the SARSA Q-tables, which increase each timestep, dual-memory learning agents "
        "exhibit flatter slopes.",
        "Entries per decision of Simple and Complex are below exact SARSA",
        _against_exact_sarsa(GROWTH),
        "below",
    ),
    Statement(
        "memory-smaller",
        "paper",
        "By abstracting the states with the equivalence classes, the number of memory entries are "
        "greatly reduced.",
        "Entries per agent of Simple and Complex at the horizon are below exact SARSA",
        _against_exact_sarsa(ENTRIES),
        "below",
    ),
    Statement(
        "communication-smaller",
        "paper",
        "The addition of communication … reduces the memory size further.",
        "Entries per agent of Complex + communication are below Complex",
        columns((COMPLEX_COMMUNICATION,), COMPLEX, ENTRIES, ALL_REWARDS),
        "below",
    ),
    Statement(
        "baselines-win",
        "ours",
        "Longest queue first and max-pressure, which learn nothing, beat every variant.",
        "W/V_c of every learning agent is above that of both baselines",
        _learners_against_baselines,
        "above",
    ),
    Statement(
        "classes-carry-the-gain",
        "ours",
        "The gain comes from the equivalence classes: SARSA on the classes has it too.",
        "W/V_c of SARSA on simple and complex classes is below exact SARSA at equal ε",
        _at_equal_epsilon("sarsa", "exact"),
        "below",
    ),
    Statement(
        "two-memories-neutral",
        "ours",
        "Splitting the memory in short and long term changes nothing measurable at this horizon.",
        f"W/V_c of dual memory is within ±{SAME_WITHIN:.0%} of SARSA on the same classes at equal "
        "ε",
        _at_equal_epsilon("dual-memory", "classes"),
        "within",
        SAME_WITHIN,
    ),
)
