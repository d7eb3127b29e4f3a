"""The paper's claims on waiting, throughput and communication."""

from __future__ import annotations

from dmil.analysis.claims import Question
from dmil.studies.paper.published import (
    COMPLEX,
    COMPLEX_COMMUNICATION,
    NO_MEMORY,
    SIMPLE,
    implied_changes,
)
from dmil.studies.paper.questions import (
    ARRIVED,
    PHYSICAL,
    SAME_WITHIN,
    WAIT,
    WAIT_UNDIVIDED,
    PaperClaim,
    at_equal_epsilon,
    by_reward,
    claim,
    columns,
    complex_against_others,
    longer_communication,
    percent,
    rewards,
)

_SAME = percent(SAME_WITHIN)


_CHANGES = sorted(implied_changes("entropy", "default"))
_IMPLIED = f"{-100 * _CHANGES[-1]:.0f} to {-100 * _CHANGES[0]:.0f} %"
"""Between what the changes lie that the paper's own table implies."""


WAITING: tuple[PaperClaim, ...] = (
    claim(
        "reward-effect",
        "The performance of intersection control can be enhanced further if different reward "
        "functions are used.",
        Question(
            "W/V_c under entropy and diffusion is below that under default",
            rewards(PHYSICAL, "default", WAIT),
            "below",
        ),
    ),
    claim(
        "memory-beats-sarsa",
        "for both the 3×3 and 5×5 networks, memory-based agents perform better than the SARSA "
        "agents.",
        *by_reward(
            "W/V_c of Simple and Complex is below No Memory",
            lambda chosen: columns((SIMPLE, COMPLEX), NO_MEMORY, WAIT, chosen),
            "below",
        ),
        note="Under default the paper's own Table II has Complex above No Memory: .24 against .19 "
        "on 3×3, .26 against .17 on 5×5.",
    ),
    claim(
        "simple-wins-default",
        "3×3 and 5×5, default: Simple .16 and .16, No Memory .19 and .17.",
        Question(
            "W/V_c of Simple is below No Memory under default",
            columns((SIMPLE,), NO_MEMORY, WAIT, ("default",)),
            "below",
        ),
        place="Table II",
        kind="table",
    ),
    claim(
        "complex-loses-default",
        "3×3 and 5×5, default: Complex .24 and .26, No Memory .19 and .17.",
        Question(
            "W/V_c of Complex is above No Memory under default",
            columns((COMPLEX,), NO_MEMORY, WAIT, ("default",)),
            "above",
        ),
        place="Table II",
        kind="table",
    ),
    claim(
        "single-intersection",
        "In the single-intersection case, the dual-memory agent has a longer average waiting time "
        "than the SARSA agent.",
        *by_reward(
            "W/V_c of Simple and Complex is above No Memory at one intersection",
            lambda chosen: columns((SIMPLE, COMPLEX), NO_MEMORY, WAIT, chosen, "single"),
            "above",
        ),
    ),
    claim(
        "complex-gains-most",
        "the largest improvement from different reward functions occurs in the memory with the "
        "complex equivalence embedding.",
        Question(
            "The ratio of W/V_c to that under default is lower for Complex than for Simple "
            "and No Memory",
            complex_against_others,
            "below",
        ),
    ),
    claim(
        "rewards-alike",
        "entropy and diffusion reward yield nearly identical V_c performance.",
        Question(
            f"V_c under entropy is within ±{_SAME} of that under diffusion",
            rewards(("entropy",), "diffusion", ARRIVED, "several"),
            "within",
            SAME_WITHIN,
        ),
    ),
    claim(
        "waiting-30",
        "Using entropy and diffusion decreased W up to 30%",
        Question(
            "W/V_c falls by less than 30 % from that under default",
            rewards(PHYSICAL, "default", WAIT),
            "above",
            -0.30,
            label="in W/V_c",
        ),
        Question(
            "W, not divided by V_c, falls by less than 30 %",
            rewards(PHYSICAL, "default", WAIT_UNDIVIDED),
            "above",
            -0.30,
            label="in W alone",
        ),
        note="Up to 30 % is not at least 30 %: more is a larger gain than the paper claims. Its "
        f"own Table II, to which the sentence points, implies {_IMPLIED} "
        "in W/V_c (.26 to .06 for Complex on 5×5).",
    ),
    claim(
        "throughput-100",
        "Using entropy and diffusion … increased the vehicle throughput by more than 100%",
        Question(
            "Some architecture has more than twice the V_c that it has under default",
            rewards(PHYSICAL, "default", ARRIVED, "several"),
            "above",
            1.0,
            "any",
        ),
        note="The figure that the sentence points to was not available to us. Under the rates and "
        "the horizon assumed here not even longest queue first doubles V_c: the verdict is on "
        "these assumptions as much as on the paper.",
    ),
    claim(
        "classes-infer",
        "Using equivalence classes allows the agent to infer the best action for states without "
        "ever seeing them before.",
        *by_reward(
            "W/V_c of SARSA on simple and complex classes is below SARSA on exact states, at "
            "equal ε,",
            lambda chosen: at_equal_epsilon("sarsa", "exact", chosen),
            "below",
        ),
        note="Judged by SARSA, which differs in nothing else with and without classes.",
    ),
    claim(
        "throughput-improved",
        "simulation experiments on several intersection networks showcase improved congestion "
        "performance (e.g., vehicle throughput) from our method.",
        *by_reward(
            "V_c of Simple and Complex is above No Memory",
            lambda chosen: columns((SIMPLE, COMPLEX), NO_MEMORY, ARRIVED, chosen),
            "above",
        ),
        place="Abstract",
    ),
    claim(
        "communication-raises-default",
        "introducing communication often increased waiting times in the 3×3 and 5×5 grid settings "
        "with the default reward function",
        Question(
            "On some grid W/V_c of Complex + communication is above Complex under default",
            columns((COMPLEX_COMMUNICATION,), COMPLEX, WAIT, ("default",)),
            "above",
            quantifier="any",
            needs_difference=True,
        ),
        note="The paper's own Table II has .24 to .25 on 3×3 and, the other way, .26 to .24 on "
        "5×5, both within its ±.",
    ),
    claim(
        "communication-no-gain-default",
        "communication does not necessarily improve global optimality",
        Question(
            "On some grid W/V_c of Complex + communication is not below Complex under default "
            "(shown unless the whole interval is below)",
            columns((COMPLEX_COMMUNICATION,), COMPLEX, WAIT, ("default",)),
            "not below",
            quantifier="any",
            label="in short runs",
            needs_difference=True,
        ),
        Question(
            "W of Complex + communication is not below Complex",
            longer_communication,
            "not below",
            quantifier="any",
            label="in longer runs",
            needs_difference=True,
        ),
        place="§VI-A",
    ),
    claim(
        "communication-neutral",
        "this phenomenon doesn't occur with the other two reward signals.",
        Question(
            f"W/V_c of Complex + communication is less than {_SAME} above Complex under "
            "entropy and diffusion",
            columns((COMPLEX_COMMUNICATION,), COMPLEX, WAIT, PHYSICAL),
            "below",
            SAME_WITHIN,
            label="in short runs",
            needs_difference=True,
        ),
        Question(
            f"W of Complex + communication is less than {_SAME} above Complex",
            longer_communication,
            "below",
            SAME_WITHIN,
            label="in longer runs",
            needs_difference=True,
        ),
        note="The phenomenon: communication makes waiting longer. The longer runs are those under "
        "What agents exchange: in short ones long-term memories hardly change, so that agents "
        "with and without communication act alike.",
    ),
)
