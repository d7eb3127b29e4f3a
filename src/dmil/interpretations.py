"""Where we read, fill in or correct the paper: one table for settings, report and docs/paper.md.

Marks: P, stated by the paper; A, assumed: open in the paper, and the only reading tried that gives
its magnitudes; F, fitted to its table, stated nowhere; corrected; ours.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Mark = Literal["P", "A", "F", "corrected", "ours"]

MEANING: dict[Mark, str] = {
    "P": "stated",
    "A": "assumed",
    "F": "fitted",
    "corrected": "corrected",
    "ours": "ours",
}
"""What a mark says, in a word."""


@dataclass(frozen=True, slots=True)
class Interpretation:
    """One choice, beside what the paper says of it.

    Attributes
    ----------
    topic: str
        Part of the system.
    what: str
        What is chosen.
    paper: str
        What the paper says; words of its own stand in quotation marks.
    here: str
        What we do by default.
    mark: str
        Where that comes from.
    setting: str
        Dotted name of the field that holds it, as in a study's configuration; empty if it is built
        in or more than one field.
    change: str
        How it is changed; empty if it is built in.
    """

    topic: str
    what: str
    paper: str
    here: str
    mark: Mark
    setting: str = ""
    change: str = ""


OPEN = "not mentioned"

ROADS = "Road network and demand"
QUEUES = "Queues"
MEASURES = "Measurements"
REWARDS = "Rewards"
CLASSES = "Equivalence classes"
AGENTS = "Agents"
CENTRAL = "Central unit"
TRAINING = "Training and testing"


def _on(topic: str, *rows: tuple[str, ...]) -> tuple[Interpretation, ...]:
    return tuple(Interpretation(topic, *row) for row in rows)  # type: ignore[arg-type]


INTERPRETATIONS: tuple[Interpretation, ...] = (
    *_on(
        ROADS,
        (
            "arrival rates λ_D",
            "{5, 5, 10, 7}, no unit of time, no order of the directions",
            "5, 5, 10, 7 vehicles per minute at each fringe node of E, N, W, S, the order in which "
            "the paper names them; per step or per action interval is off by a factor",
            "A",
            "demand.rate_veh_per_min",
            "--rates",
        ),
        (
            "arrival processes",
            "Poisson; “e.g., compound Poisson processes” and real data are named",
            "Poisson; compound Poisson, rates over time, and vehicles of files are offered",
            "P",
            "demand.arrivals",
            "--arrivals, --batch, --profile",
        ),
        (
            "origin and destination",
            "“generated uniformly at random with the starting node excluded”",
            "the same",
            "P",
        ),
        (
            "equally short ways",
            "“the shortest path”, no rule for ties",
            "straight on while that shortens the way, a coin drawn in advance for what is still "
            "open. On a grid straight-first leaves one way per pair of nodes: the coin never falls "
            "there. `coin` has no preference",
            "A",
            "ties",
            "--ties coin",
        ),
        (
            "time on a link between intersections",
            OPEN,
            "5 s",
            "A",
            "grid.link_time_s",
            "--set grid.link_time_s=…",
        ),
        (
            "time on an entry or exit link",
            OPEN,
            "0 s",
            "A",
            "grid.entry_link_time_s",
            "--set grid.entry_link_time_s=…",
        ),
        (
            "randomness of demand",
            OPEN,
            "drawn from the seed before the run, equal for all controllers: comparisons are paired",
            "ours",
        ),
    ),
    *_on(
        QUEUES,
        (
            "dynamics of a served orientation",
            "x_{t+1} − x_t = **+**min(x, v*)",
            "−min(x, v*), plus arrivals: the sign is a slip, and arrivals are missing",
            "corrected",
        ),
        (
            "a queue",
            "one count per orientation",
            "first in, first out, without limit: nobody is held up by another orientation",
            "A",
            "dynamics.storage",
            "--set dynamics.storage=true",
        ),
        (
            "v*",
            "a positive whole number",
            "1 vehicle per step",
            "A",
            "dynamics.saturation_flow_veh_per_s",
            "--set dynamics.saturation_flow_veh_per_s=…",
        ),
        ("length of a step", OPEN, "1 s", "A"),
        (
            "t_a, duration of an action",
            "10",
            "10 steps",
            "P",
            "timing.decision_interval_s",
            "--set timing.decision_interval_s=…",
        ),
        (
            "yellow, all-red, start-up losses",
            OPEN,
            "none in the paper's setting; options for real networks",
            "A",
            "timing.clearance_s",
            "--set timing.clearance_s=…",
        ),
        (
            "order within a step",
            OPEN,
            "decisions (on the state before arrivals), arrivals, vehicles that reach the end of "
            "their link, discharge, measurements",
            "A",
        ),
        (
            "right turns",
            "“permitted whenever”",
            "always served; their queues are part of the state",
            "P",
        ),
    ),
    *_on(
        MEASURES,
        (
            "W",
            "“average waiting time … of all vehicles in the network”",
            "vehicle-steps queued / vehicles spawned: those still waiting, and those on their way, "
            "are in the denominator",
            "A",
        ),
        (
            "normalisation of Table II",
            "“We normalized the number with” V_c at t = 300",
            "W / V_c at the horizon",
            "P",
        ),
        (
            "T_sim",
            "no number, but t = 300",
            "300 s, 30 decisions",
            "A",
            "horizon_s",
            "--steps",
        ),
        ("± of Table II", OPEN, "taken as the standard deviation over seeds, as ours is", "A"),
        (
            "size of memory",
            "m_L, for SARSA the size of the Q-table, “averaged over all intersections”",
            "the same, and beside it m_s + m_L, what all share counted once, and true bytes",
            "P",
        ),
    ),
    *_on(
        REWARDS,
        (
            "from which state to which",
            "x_t to x_{t+1}, “per timestep”",
            "over a decision interval, from one decision to the next: an action lasts t_a steps",
            "A",
        ),
        (
            "α, relaxation of the default reward",
            "1.1",
            "1.1; the paper's other α, the learning rate, is another number",
            "P",
            "reward_constants.relaxation_veh",
            "--set reward_constants.relaxation_veh=…",
        ),
        (
            "θ of the default reward",
            "10",
            "10",
            "P",
            "reward_constants.tolerated_veh",
            "--set reward_constants.tolerated_veh=…",
        ),
        (
            "diffusion",
            "−mean(sign(d) d²)",
            "the mean is over all orientations, right turns and empty ones included",
            "A",
        ),
        (
            "entropy",
            "w_{k+1} − w_k, w = −Σ s ln s of the “states”",
            "of the counts, not normalised to a distribution (normalising breaks it); 0·ln 0 = 0",
            "A",
        ),
    ),
    *_on(
        CLASSES,
        (
            "distance of a “shift-invariance of 1 radial distance”",
            "no norm",
            "1 vehicle in any orientation (L∞); with L1 half the gain is gone, and a uniform shift "
            "does nothing",
            "A",
            "tolerance",
            "--set tolerance=…",
        ),
        (
            "complex",
            "“adds two more definitions of equivalence to the simple embedding: rotational "
            "equivariance and scale invariance”",
            "some rotation of one state is within the tolerance of the other, as counted or after "
            "scaling; `complex-scaled`, which has the tolerance after scaling only and does not "
            "contain simple, runs beside it",
            "P",
            "complex_readings",
            "--complex-readings",
        ),
        (
            "scale invariance",
            "no formula",
            "⌊B·x/max(x) + ½⌋ with B = 5, an empty state is 0",
            "F",
            "scale_levels",
            "--set scale_levels=…",
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
            "called equivalence classes",
            "the relation is not transitive: the first key wins, so classes depend on the order of "
            "arrival",
            "ours",
        ),
        (
            "rotations",
            "four",
            "found from the intersection; the paper's has exactly these four, a mirror is no "
            "symmetry",
            "ours",
        ),
        ("cells, ⌊(x+1)/3⌋", "–", "offered: transitive, one look-up", "ours"),
    ),
    *_on(
        AGENTS,
        (
            "learning rate",
            "α, no number",
            "0.1",
            "A",
            "learning_rate",
            "--set learning_rate=…",
        ),
        ("γ", "0.95", "0.95", "P", "discount", "--set discount=…"),
        (
            "ε of agents with and without memory",
            "0.4 and 0.6",
            "the same; SARSA also runs with 0.4, so that all agents meet at equal ε",
            "P",
            "epsilon",
            "--set epsilon=…",
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
            "--set least_tried=…",
        ),
        (
            "“significantly”",
            "no number",
            "q > old + 0.1·|old|",
            "A",
            "significance",
            "--set significance=…",
        ),
        (
            "a state without an entry",
            OPEN,
            "a uniformly random action",
            "A",
            "unseen",
            "--set unseen=…",
        ),
        (
            "size of short-term memory",
            "stages when it “is full”, no number",
            "m_s = 16 rows; it stages when it holds 16",
            "A",
            "short_capacity",
            "--set short_capacity=…",
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
            "stage_untried",
            "--set stage_untried=true",
        ),
        (
            "κ",
            "½ (“m_s/2 states”)",
            "½, rounded up to whole rows",
            "P",
            "staged_ratio",
            "--set staged_ratio=…",
        ),
        (
            "T_stage of the analysis",
            "a period; Algorithm 1 stages when full",
            "Algorithm 1; the period is offered",
            "P",
            "stage_period",
            "--set stage_period=…",
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
    ),
    *_on(
        CENTRAL,
        (
            "T",
            "“every T seconds”, no number",
            "100 s",
            "A",
            "communication_period_s",
            "--set communication_period_s=…",
        ),
        (
            "what is sent",
            "“current memory (STM or LTM)”",
            "long-term memory; for SARSA the Q-table",
            "A",
            "sent",
            "--set sent=…",
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
            "who has none has no 0 to add",
            "A",
        ),
        (
            "what comes back",
            "“synchronises them”",
            "every agent's memory is replaced by the union; of a class long-term memory keeps the "
            "action with the highest mean",
            "A",
        ),
        (
            "who meets",
            "all agents",
            "all agents of one shape of intersection: on grids all",
            "ours",
        ),
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
            "--set trigger=…",
        ),
        (
            "delay and loss of messages",
            "“synchronization delay effects” are future work",
            "none; offered: an agent takes the answer over when it arrives, and keeps what the "
            "answer lacks",
            "P",
            "communication_delay_s",
            "--set communication_delay_s=…, --set message_loss=…",
        ),
        (
            "predictions from neighbours",
            "future work",
            "none; offered: states count those who approach, and those whom neighbours send if "
            "all signals stay",
            "P",
            "announced",
            "--set announced=true",
        ),
    ),
    *_on(
        TRAINING,
        (
            "length of the training phase",
            "T_sim",
            "T_sim under `literal` and `decaying`; 10·T_sim under `matched`",
            "F",
            "training_factor",
            "--preset",
        ),
        (
            "ε_train",
            "0.1",
            "0.1",
            "P",
            "training_epsilon",
            "--set training_epsilon=…",
        ),
        (
            "the dummy SARSA agent",
            "“a dummy SARSA agent”",
            "exact states, one table that all intersections of a shape write to, the reward of the "
            "test, vehicles of another stream of the seed; the agents under test have a table each",
            "A",
        ),
        (
            "“the Q-table … is fed into all the agents”",
            "no rule",
            "SARSA imports all rows; dual memory the κ of them with the highest Q, through "
            "Algorithm 2, into long-term memory",
            "A",
        ),
        (
            "during the test",
            OPEN,
            "agents go on learning",
            "A",
        ),
        (
            "ε during the test",
            "one number",
            "constant under `literal`; × 0.95 per decision under `decaying` and `matched`",
            "F",
            "epsilon_decay",
            "--preset",
        ),
        (
            "“No Memory” of Table II",
            "SARSA",
            "exact SARSA under `literal` and `decaying`; SARSA on the simple classes under "
            "`matched`",
            "F",
            "no_memory_embedding",
            "--preset",
        ),
        ("seeds", "30", "30", "P", "seeds", "--seeds"),
    ),
)
"""Every choice, in the order of the system."""

TOPICS: tuple[str, ...] = tuple(dict.fromkeys(each.topic for each in INTERPRETATIONS))

_MARKS = {each.setting: each.mark for each in INTERPRETATIONS if each.setting}


def mark(setting: str) -> str:
    """Return the mark of a setting as its description ends in it: "[A]" (ours).

    Raises
    ------
    KeyError
        If the table has no such setting.
    """
    return f"[{_MARKS[setting]}]"


def interpretations_markdown(topic: str) -> str:
    """Return the table of a topic as docs/paper.md has it (ours)."""
    lines = ["| what | paper | here | mark | change it by |", "|-|-|-|-|-|"]
    for each in INTERPRETATIONS:
        if each.topic == topic:
            change = f"`{each.change}`" if each.change else ""
            row = (each.what, each.paper, each.here, each.mark, change)
            lines.append("| " + " | ".join(cell.replace("|", r"\|") for cell in row) + " |")
    return "\n".join(lines) + "\n"
