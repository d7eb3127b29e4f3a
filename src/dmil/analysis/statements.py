"""All that is claimed, by the paper and by us."""

from __future__ import annotations

from dmil.analysis.memory_statements import MEMORY
from dmil.analysis.questions import (
    SAME_WITHIN,
    Question,
    Statement,
    percent,
)
from dmil.analysis.selections import (
    at_equal_epsilon,
    learners_against_baselines,
)
from dmil.analysis.waiting_statements import WAITING

_SAME = percent(SAME_WITHIN)


OURS: tuple[Statement, ...] = (
    Statement(
        "baselines-win",
        "ours",
        "",
        "Longest queue first and max-pressure, which learn nothing, beat every variant.",
        (
            Question(
                "W/V_c of every learning agent is above that of both baselines",
                learners_against_baselines,
                "above",
            ),
        ),
    ),
    Statement(
        "classes-carry-the-gain",
        "ours",
        "",
        "The gain comes from the equivalence classes: SARSA on the classes has it too.",
        (
            Question(
                "W/V_c of SARSA on simple and complex classes is below exact SARSA at equal ε",
                at_equal_epsilon("sarsa", "exact"),
                "below",
            ),
        ),
    ),
    Statement(
        "two-memories-neutral",
        "ours",
        "",
        f"Splitting the memory in short and long term changes waiting by less than {_SAME}.",
        (
            Question(
                f"W/V_c of dual memory is within ±{_SAME} of SARSA on the same classes at equal ε",
                at_equal_epsilon("dual-memory", "classes"),
                "within",
                SAME_WITHIN,
            ),
        ),
    ),
)

STATEMENTS: tuple[Statement, ...] = (*WAITING, *MEMORY, *OURS)
"""In the order of the report."""
