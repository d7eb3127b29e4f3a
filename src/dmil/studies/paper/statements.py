"""All that is claimed, by the paper and by us."""

from __future__ import annotations

from dmil.analysis.claims import Question
from dmil.studies.paper.memory_statements import MEMORY
from dmil.studies.paper.questions import SAME_WITHIN, PaperClaim, by_reward, claim, percent
from dmil.studies.paper.selections import PHYSICAL, at_equal_epsilon, learners_against_baselines
from dmil.studies.paper.waiting_statements import WAITING

_SAME = percent(SAME_WITHIN)


OURS: tuple[PaperClaim, ...] = (
    claim(
        "baselines-win",
        "Longest queue first and max-pressure, which learn nothing and never explore, beat every "
        "architecture.",
        Question(
            "W/V_c of every learning agent is above that of both baselines",
            learners_against_baselines,
            "above",
        ),
        place="",
        kind="ours",
    ),
    claim(
        "classes-carry-the-gain",
        "SARSA on the same classes has the gain of dual memory, too, under entropy and diffusion: "
        "it comes from the classes, not from the two memories.",
        Question(
            "W/V_c of SARSA on simple and complex classes is below exact SARSA at equal ε",
            at_equal_epsilon("sarsa", "exact", PHYSICAL),
            "below",
        ),
        place="",
        kind="ours",
    ),
    claim(
        "two-memories-neutral",
        f"Splitting the memory in short and long term changes waiting by less than {_SAME}.",
        *by_reward(
            f"W/V_c of dual memory is within ±{_SAME} of SARSA on the same classes at equal ε",
            lambda chosen: at_equal_epsilon("dual-memory", "classes", chosen),
            "within",
            SAME_WITHIN,
        ),
        place="",
        kind="ours",
    ),
)

STATEMENTS: tuple[PaperClaim, ...] = (*WAITING, *MEMORY, *OURS)
"""In the order of the report."""
