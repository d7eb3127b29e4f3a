"""Roads, demand, queues, what is measured, rewards."""

from __future__ import annotations

from dmil.interpretations.model import OPEN, on

ROADS = on(
    "Road network and demand",
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
    ("time on a link between intersections", OPEN, "5 s", "A", "grid.link_time_s"),
    ("time on an entry or exit link", OPEN, "0 s", "A", "grid.entry_link_time_s"),
    (
        "randomness of demand",
        OPEN,
        "drawn from the seed before the run, equal for all controllers: comparisons are paired",
        "ours",
    ),
)

QUEUES = on(
    "Queues",
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
    ),
    ("length of a step", OPEN, "1 s", "A"),
    ("t_a, duration of an action", "10", "10 steps", "P", "timing.decision_interval_s"),
    (
        "yellow, all-red, start-up losses",
        OPEN,
        "none in the paper's setting; options for real networks",
        "A",
        "timing.clearance_s",
    ),
    (
        "order within a step",
        OPEN,
        "decisions (on the state before arrivals), arrivals, vehicles that reach the end of "
        "their link, discharge, measurements",
        "A",
    ),
    (
        "the state, x_t(j)",
        "“the amount of traffic present at time t”",
        "vehicles queued in orientation j; those that drive towards it are not in it",
        "A",
    ),
    ("the actions", "“One example design”: eight modes", "those eight", "P"),
    ("at the start", OPEN, "the network is empty", "A"),
    (
        "right turns",
        "“permitted whenever”",
        "always served; their queues are part of the state",
        "P",
    ),
)

MEASURES = on(
    "Measurements",
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
        "length of a test run",
        "no number, but V_c at t = 300",
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
)

REWARDS = on(
    "Rewards",
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
    ),
    ("θ of the default reward", "10", "10", "P", "reward_constants.tolerated_veh"),
    (
        "diffusion",
        "−mean(sign(d) d²)",
        "the mean is over all orientations, right turns and empty ones included",
        "A",
    ),
    (
        "entropy",
        "w_{k+1} − w_k, w = −Σ s ln s, modified “to retain magnitude and sign information”",
        "of the counts, not normalised to a distribution, which would lose the magnitude; "
        "0·ln 0 = 0",
        "P",
    ),
)
