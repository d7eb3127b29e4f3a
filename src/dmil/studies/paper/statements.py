"""All that is claimed, by the paper and by us; here on memory and what it costs, and ours."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from dmil.analysis.claims import Question
from dmil.studies.paper.published import COMPLEX, COMPLEX_COMMUNICATION, NO_MEMORY, SIMPLE
from dmil.studies.paper.questions import (
    ALL_REWARDS,
    ENTRIES,
    GROWTH,
    LONG_ENTRIES,
    LONG_GROWTH,
    NOTICEABLE,
    PHYSICAL,
    SAME_WITHIN,
    TOTAL_ENTRIES,
    WAIT,
    Choose,
    PaperClaim,
    Where,
    against_exact_sarsa,
    against_no_memory,
    at_equal_epsilon,
    by_reward,
    claim,
    columns,
    learners_against_baselines,
    percent,
)
from dmil.studies.paper.waiting_statements import WAITING

_SAME, _SLIGHT = percent(SAME_WITHIN), percent(NOTICEABLE)

RIVALS: tuple[tuple[str, Callable[[str], Choose]], ...] = (
    ("exact SARSA", against_exact_sarsa),
    ("No Memory", against_no_memory),
)
"""Whose table memory is compared with: the paper's own agent, and the preset's."""

_EXPENSES: tuple[tuple[str, tuple[str, ...], Where], ...] = (
    ("on several intersections under entropy and diffusion", PHYSICAL, "several"),
    ("on several under default", ("default",), "several"),
    ("on one", ALL_REWARDS, "single"),
)


MEMORY: tuple[PaperClaim, ...] = (
    claim(
        "memory-flatter",
        "Unlike the SARSA Q-tables, which increase each timestep, dual-memory learning agents "
        "exhibit flatter slopes, indicating a slower growth rate.",
        *(
            Question(
                f"{counted} per decision of Simple and Complex is below {rival}'s table",
                choose(measure),
                "below",
                label=f"{short} against {rival}",
            )
            for counted, short, measure in (
                ("m_L", "m_L", LONG_GROWTH),
                ("m_s + m_L", "m_s + m_L", GROWTH),
            )
            for rival, choose in RIVALS
        ),
        note="The paper records m_L. m_s + m_L is ours: it counts short-term memory, too, which "
        "never holds more than m_s rows however long a run is. In a run this short it may not "
        "fill even once: then nothing is staged, and m_L stays what it was at the start.",
    ),
    claim(
        "memory-smaller",
        "By abstracting the states with the equivalence classes, the number of memory entries are "
        "greatly reduced",
        *(
            Question(
                f"{counted} per agent of Simple and Complex at the horizon is less than half of "
                f"{rival}'s table",
                choose(measure),
                "below",
                -0.5,
                label=f"{counted} against {rival}",
            )
            for counted, measure in (("m_L", LONG_ENTRIES), ("m_s + m_L", ENTRIES))
            for rival, choose in RIVALS
        ),
        note="Greatly reduced is read as at least halved. Much of it is decided at the start: dual "
        "memory imports the best half of the trained table, one action each, SARSA all of it.",
    ),
    claim(
        "similar-metrics",
        "the number of memory entries are greatly reduced, while having similar or even better "
        "congestion metrics.",
        *by_reward(
            f"W/V_c of Simple and Complex is less than {_SAME} above exact SARSA",
            lambda chosen: against_exact_sarsa(WAIT, rewards=chosen),
            "below",
            SAME_WITHIN,
        ),
        note=f"Similar is read as less than {_SAME} above.",
    ),
    claim(
        "split-smaller",
        "The separation into short-term and long-term memories serves the purpose of further "
        "minimizing memory usage.",
        Question(
            "Entries per agent of dual memory are below SARSA on the same classes at equal ε",
            at_equal_epsilon("dual-memory", "classes", ALL_REWARDS, ENTRIES),
            "below",
        ),
        place="§IV-B",
        note="An entry of long-term memory holds one action, one of SARSA's table a Q of every "
        "action.",
    ),
    claim(
        "communication-smaller",
        "the addition of communication … reduces the memory size further",
        Question(
            f"Entries per agent of Complex + communication are at least {_SLIGHT} below Complex",
            columns((COMPLEX_COMMUNICATION,), COMPLEX, ENTRIES, ALL_REWARDS),
            "below",
            -NOTICEABLE,
            label="per agent",
        ),
        Question(
            "Entries of all agents, what all share counted once, of Complex + communication "
            f"are at least {_SLIGHT} below Complex",
            columns((COMPLEX_COMMUNICATION,), COMPLEX, TOTAL_ENTRIES, ALL_REWARDS),
            "below",
            -NOTICEABLE,
            label="counted once",
        ),
        note="Both follow from the rule: the central unit returns the union of what it was sent, "
        "which can only add entries to an agent, and makes them the same for all. Counted once is "
        "a way of storing: the start table, too, is the same for all agents, but each has a copy "
        "until they communicate.",
    ),
    claim(
        "simple-smaller",
        "even the simple equivalence embedding method reduces the memory size further",
        Question(
            "Entries per agent of Simple at the horizon are below exact SARSA",
            against_exact_sarsa(ENTRIES, (SIMPLE,)),
            "below",
            label="against exact SARSA",
        ),
        Question(
            "Entries per agent of Simple at the horizon are below Complex",
            columns((SIMPLE,), COMPLEX, ENTRIES, ALL_REWARDS),
            "below",
            label="against Complex",
        ),
        note="The sentence does not say further than what.",
    ),
    claim(
        "tiny-decrease",
        "the addition of communication and even the simple equivalence embedding method reduces "
        "the memory size further with a tiny congestion performance decrease.",
        Question(
            f"W/V_c of Complex + communication is less than {_SAME} above Complex",
            columns((COMPLEX_COMMUNICATION,), COMPLEX, WAIT, ALL_REWARDS),
            "below",
            SAME_WITHIN,
            label="with communication",
            needs_difference=True,
        ),
        Question(
            f"W/V_c of Simple is less than {_SAME} above Complex",
            columns((SIMPLE,), COMPLEX, WAIT, ALL_REWARDS),
            "below",
            SAME_WITHIN,
            label="with Simple for Complex",
        ),
        note=f"Tiny is read as less than {_SAME}.",
    ),
    claim(
        "little-expense",
        "memory growth rate is reduced with little expense on the performance.",
        *(
            Question(
                f"W/V_c of Simple and Complex is less than {_SAME} above No Memory, {label}",
                columns((SIMPLE, COMPLEX), NO_MEMORY, WAIT, chosen, where),
                "below",
                SAME_WITHIN,
                label=label,
            )
            for label, chosen, where in _EXPENSES
        ),
        place="§VII",
        note=f"Little is read as less than {_SAME}. The paper's own Table II has 14 to 38 % more "
        "on 1×1, and 26 and 53 % more for Complex under default.",
    ),
)


_ours = partial(claim, place="", kind="ours")

OURS: tuple[PaperClaim, ...] = (
    _ours(
        "baselines-win",
        "Longest queue first and max-pressure, which learn nothing and never explore, beat every "
        "architecture.",
        Question(
            "W/V_c of every learning agent is above that of both baselines",
            learners_against_baselines,
            "above",
        ),
    ),
    _ours(
        "classes-carry-the-gain",
        "SARSA on the same classes has the gain of dual memory, too, under entropy and diffusion: "
        "it comes from the classes, not from the two memories.",
        Question(
            "W/V_c of SARSA on simple and complex classes is below exact SARSA at equal ε",
            at_equal_epsilon("sarsa", "exact", PHYSICAL),
            "below",
        ),
    ),
    _ours(
        "two-memories-neutral",
        f"Splitting the memory in short and long term changes waiting by less than {_SAME}.",
        *by_reward(
            f"W/V_c of dual memory is within ±{_SAME} of SARSA on the same classes at equal ε",
            lambda chosen: at_equal_epsilon("dual-memory", "classes", chosen),
            "within",
            SAME_WITHIN,
        ),
    ),
)

STATEMENTS: tuple[PaperClaim, ...] = (*WAITING, *MEMORY, *OURS)
"""In the order of the report."""
