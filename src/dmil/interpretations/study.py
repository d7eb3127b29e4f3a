"""The central unit, training and testing."""

from __future__ import annotations

from dmil.interpretations.model import OPEN, on

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
