"""All that is claimed, by the paper and by us."""

from __future__ import annotations

from dmil.studies.paper.memory_statements import MEMORY
from dmil.studies.paper.questions import BY_REWARD, SAME_WITHIN, Claim, Question, percent
from dmil.studies.paper.selections import PHYSICAL, at_equal_epsilon, learners_against_baselines
from dmil.studies.paper.waiting_statements import WAITING

_SAME = percent(SAME_WITHIN)


OURS: tuple[Claim, ...] = (
    Claim(
        "baselines-win",
        "ours",
        "",
        "Longest queue first and max-pressure, which learn nothing and never explore, beat every "
        "architecture.",
        (
            Question(
                "W/V_c of every learning agent is above that of both baselines",
                learners_against_baselines,
                "above",
            ),
        ),
    ),
    Claim(
        "classes-carry-the-gain",
        "ours",
        "",
        "SARSA on the same classes has the gain of dual memory, too, under entropy and diffusion: "
        "it comes from the classes, not from the two memories.",
        (
            Question(
                "W/V_c of SARSA on simple and complex classes is below exact SARSA at equal ε",
                at_equal_epsilon("sarsa", "exact", PHYSICAL),
                "below",
            ),
        ),
    ),
    Claim(
        "two-memories-neutral",
        "ours",
        "",
        f"Splitting the memory in short and long term changes waiting by less than {_SAME}.",
        tuple(
            Question(
                f"W/V_c of dual memory is within ±{_SAME} of SARSA on the same classes at equal ε "
                f"{label}",
                at_equal_epsilon("dual-memory", "classes", chosen),
                "within",
                SAME_WITHIN,
                label=label,
            )
            for label, chosen in BY_REWARD
        ),
    ),
)

STATEMENTS: tuple[Claim, ...] = (*WAITING, *MEMORY, *OURS)
"""In the order of the report."""
