"""Equivalence classes and agents."""

from __future__ import annotations

from dmil.interpretations.model import OPEN, on

CLASSES = on(
    "Equivalence classes",
    (
        "distance of a “shift-invariance of 1 radial distance”",
        "no norm; “similar to” an earlier paper",
        "1 vehicle in any orientation (L∞); with L1 half the gain is gone, and a uniform shift "
        "does nothing",
        "A",
        "tolerance",
    ),
    (
        "complex",
        "“adds two more definitions of equivalence to the simple embedding: rotational "
        "equivariance and scale invariance”",
        "some rotation of one state is within the tolerance of the other, as counted or after "
        "scaling; `complex-scaled`, which has the tolerance after scaling only and does not "
        "contain simple, runs beside it",
        "A",
        "complex_readings",
        "--complex-readings",
    ),
    (
        "scale invariance",
        "no formula",
        "⌊B·x/max(x) + ½⌋ with B = 5, an empty state is 0",
        "F",
        "scale_levels",
    ),
    (
        "several keys match",
        OPEN,
        "the nearest by L1, then the oldest; one that matches as counted goes before one that "
        "matches scaled",
        "A",
    ),
    (
        "transitivity",
        "states are “compared with the existing key states”, “Otherwise, a new key state is "
        "created”",
        "the same; the relation is not transitive, so classes depend on the order of arrival",
        "P",
    ),
    (
        "rotations",
        "“rotational equivariance”, no number",
        "found from the intersection; the paper's has exactly these four, a mirror is no symmetry",
        "ours",
    ),
    ("cells, ⌊(x+1)/3⌋", "–", "offered: transitive, one look-up", "ours"),
)

AGENTS = on(
    "Agents",
    ("learning rate", "α, no number", "0.1", "A", "learning_rate"),
    ("γ", "0.95", "0.95", "P", "discount"),
    (
        "ε of agents with and without memory",
        "0.4 and 0.6",
        "the same; SARSA also runs with 0.4, so that all agents meet at equal ε",
        "P",
        "epsilon",
    ),
    ("Q₀, Q of what was never tried", OPEN, "0", "A"),
    (
        "choice of SARSA in a state with an entry",
        "“fetch the best state-action pair”",
        "the highest Q, untried actions with their 0 included, ties at random",
        "A",
    ),
    (
        "choice of dual memory",
        "“the action stored in LTM takes priority unless the reward for the action in STM is "
        "significantly higher”",
        "the same; short-term memory offers the best action that was tried, the first of "
        "equals, and never an untried one",
        "A",
        "least_tried",
    ),
    ("“significantly”", "no number", "q > old + 0.1·|old|", "A", "significance"),
    ("a state without an entry", OPEN, "a uniformly random action", "A", "unseen"),
    (
        "what enters short-term memory",
        "“Initially, all states”; “After some duration of time” it learns “local temporal "
        "information”",
        "every state from the first decision on; what was learned before stands in long-term "
        "memory",
        "A",
    ),
    (
        "size of short-term memory",
        "stages when it “is full”, no number",
        "m_s = 16 rows; it stages when it holds 16",
        "A",
        "short_capacity",
    ),
    (
        "which rows are staged",
        "text: “frequently occurring states”; Algorithm 1: “with the highest Q-values”",
        "Algorithm 1: the highest Q; `visits` for the text",
        "P",
        "staging",
        "--set staging=visits",
    ),
    (
        "Q of a row that is staged",
        "“best action”, “best reward”",
        "its best tried action and that Q: an untried 0 is not staged",
        "A",
    ),
    ("κ", "½ (“m_s/2 states”)", "½, rounded up to whole rows", "P", "staged_ratio"),
    (
        "T_stage of the analysis",
        "a period; Algorithm 1 stages when full",
        "Algorithm 1; the period is offered",
        "P",
        "stage_period",
    ),
    (
        "Q(S, A) in the update",
        "`getQValue`",
        "short-term Q if the action was tried there, else long-term Q if it is of the same "
        "action, else 0",
        "A",
    ),
    (
        "end of a run",
        "“while not done”",
        "the horizon cuts a task that goes on; nothing is learned from the last interval",
        "A",
    ),
)
