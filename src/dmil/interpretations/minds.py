"""Equivalence classes and agents, the central unit, training and testing."""

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

CENTRAL = on(
    "Central unit",
    ("T", "“every T seconds”, no number", "100 s", "A", "communication_period_s"),
    (
        "what is sent",
        "“current memory (STM or LTM)”",
        "long-term memory; for SARSA the Q-table",
        "A",
        "sent",
    ),
    (
        "communication",
        "“if include communication layer”",
        "off, but for the agents that the study calls communicating",
        "P",
        "communication",
        "--set communication=true",
    ),
    (
        "a short-term memory that comes back",
        OPEN,
        "its rows enter an emptied one as if they were learned then, oldest first, and are "
        "staged when it is full (not by default: only long-term memory is sent)",
        "ours",
    ),
    (
        "averaging",
        "“averaging the Q-values”; in §III over all N agents",
        "union of the classes, mean per class and action over the agents that have a value: "
        "an agent without one is left out of the mean",
        "A",
    ),
    (
        "what comes back",
        "“synchronises them”",
        "every agent's memory is replaced by the union; for each class, long-term memory keeps "
        "the action with the highest mean",
        "A",
    ),
    ("who meets", "all agents", "all agents of one shape of intersection: on grids all", "ours"),
    (
        "exact SARSA",
        "Table I has simple and complex classes only",
        "does not communicate: states that hardly ever recur leave nothing to average",
        "A",
    ),
    (
        "trigger",
        "periodic; “advanced triggering” is future work",
        "periodic; new entries, change of values and staging are offered",
        "P",
        "trigger",
    ),
    (
        "delay of the synchronisation",
        "“synchronization delay effects” are future work",
        "none; offered: an agent takes the answer over when it arrives, and keeps what the "
        "answer lacks",
        "P",
        "communication_delay_s",
    ),
    ("loss of messages", OPEN, "none; offered", "ours", "message_loss"),
    (
        "predictions from neighbours",
        "future work",
        "none; offered: states count those who approach, and those whom neighbours send if "
        "all signals stay",
        "P",
        "announced",
        "--set announced=true",
    ),
)

TRAINING = on(
    "Training and testing",
    (
        "T_sim, length of the training phase",
        "no number",
        "as long as a test run under `literal` and `decaying`; ten times as long under `matched`",
        "F",
        "training_factor",
        "--preset, --set training_factor=…",
    ),
    ("ε_train", "0.1", "0.1", "P", "training_epsilon"),
    (
        "the dummy SARSA agent",
        "“trained offline … of incoming vehicles, gathered from data”",
        "exact states, one table that all intersections of a shape write to, the reward of the "
        "test, vehicles of another stream of the seed; the agents under test have a table each",
        "A",
    ),
    (
        "“the Q-table … is fed into all the agents”",
        "no rule, but “all agents start from the same prior knowledge”",
        "SARSA imports all rows; dual memory the κ of them with the highest Q, one action each, "
        "through Algorithm 2, into long-term memory: the same knowledge, less of it",
        "A",
    ),
    ("during the test", OPEN, "agents go on learning", "A"),
    (
        "ε during the test",
        "one number",
        "constant under `literal`; × 0.95 per decision under `decaying` and `matched`",
        "F",
        "epsilon_decay",
        "--preset, --set epsilon_decay=…",
    ),
    (
        "“No Memory” of Table II",
        "“baseline SARSA agent”; Table I pairs the non-memory agent with the simple and complex "
        "classes",
        "exact SARSA under `literal` and `decaying`; SARSA on the simple classes under `matched`",
        "F",
        "no_memory_embedding",
        "--preset, --set no_memory_embedding=…",
    ),
    ("seeds", "30", "30", "P", "seeds", "--seeds"),
)
