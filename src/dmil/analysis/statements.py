"""What is claimed, by the paper and by us, and how it is decided."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from dmil.analysis.comparisons import Relation
from dmil.analysis.paper import COMPLEX, COMPLEX_COMMUNICATION, NO_MEMORY, SIMPLE
from dmil.analysis.selections import (
    ALL_REWARDS,
    ARRIVED,
    ENTRIES,
    GROWTH,
    PHYSICAL,
    WAIT,
    Choose,
    against_exact_sarsa,
    at_equal_epsilon,
    columns,
    complex_against_others,
    learners_against_baselines,
    rewards,
)

#: Two things count as the same if the interval of their relative difference lies within ±5 %.
SAME_WITHIN = 0.05
_SAME = f"{100 * SAME_WITHIN:.0f} %"


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
        complex_against_others,
        "below",
    ),
    Statement(
        "rewards-alike",
        "paper",
        "Entropy and diffusion reward yield nearly identical V_c performance.",
        f"V_c under entropy is within ±{_SAME} of that under diffusion",
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
        "Using entropy and diffusion … increased the vehicle throughput by more than 100%.",
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
        "This phenomenon [more waiting with communication] doesn't occur with the other two reward "
        "signals.",
        f"W/V_c of Complex + communication is within ±{_SAME} of Complex under entropy "
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
        against_exact_sarsa(GROWTH),
        "below",
    ),
    Statement(
        "memory-smaller",
        "paper",
        "By abstracting the states with the equivalence classes, the number of memory entries are "
        "greatly reduced.",
        "Entries per agent of Simple and Complex at the horizon are below exact SARSA",
        against_exact_sarsa(ENTRIES),
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
        learners_against_baselines,
        "above",
    ),
    Statement(
        "classes-carry-the-gain",
        "ours",
        "The gain comes from the equivalence classes: SARSA on the classes has it too.",
        "W/V_c of SARSA on simple and complex classes is below exact SARSA at equal ε",
        at_equal_epsilon("sarsa", "exact"),
        "below",
    ),
    Statement(
        "two-memories-neutral",
        "ours",
        f"Splitting the memory in short and long term changes waiting by less than {_SAME}.",
        f"W/V_c of dual memory is within ±{_SAME} of SARSA on the same classes at equal ε",
        at_equal_epsilon("dual-memory", "classes"),
        "within",
        SAME_WITHIN,
    ),
)
