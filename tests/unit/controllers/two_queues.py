"""Two queues before one signal: so few states that the best choices can be computed."""

from functools import cache
from itertools import product

import numpy as np

from dmil.controllers import RunContext
from dmil.network import grid
from dmil.scenarios import SignalTiming
from dmil.seeding import stream
from dmil.simulation import Observation

MOST_VEH = 3
DISCOUNT = 0.9
MOVEMENTS = (1, 8)
SERVING = (2, 5)
"""Phases that empty the first and the second queue; the other six serve nobody."""
ALTERNATING = ((1, 0), (0, 1), (2, 0), (0, 2))
"""Vehicles that join the two queues, all equally likely: who chooses well leaves nobody waiting."""
BUSY = ((2, 0), (0, 2), (2, 1), (1, 2))
"""Even who chooses well leaves vehicles waiting, more or fewer by chance."""
STATES = tuple(product(range(MOST_VEH + 1), repeat=2))


def served(state, phase):
    """Return what stays when a phase is shown."""
    return tuple(0 if phase == SERVING[q] else state[q] for q in (0, 1))


def joined(state, arrival):
    """Return the queues after an arrival."""
    return tuple(min(n + more, MOST_VEH) for n, more in zip(state, arrival, strict=True))


@cache
def best_phases(arrivals):
    """Return the phases that are best in each state, by value iteration."""
    value = dict.fromkeys(STATES, 0.0)

    def follow(state, phase):
        stays = served(state, phase)
        return -sum(stays), [joined(stays, arrival) for arrival in arrivals]

    following = {(state, phase): follow(state, phase) for state in STATES for phase in range(8)}

    def worth(state, phase):
        reward, after = following[state, phase]
        return reward + DISCOUNT * sum(value[each] for each in after) / len(after)

    for _ in range(300):
        value = {state: max(worth(state, phase) for phase in range(8)) for state in STATES}
    found = {}
    for state in STATES:
        worths = np.array([worth(state, phase) for phase in range(8)])
        found[state] = set(np.flatnonzero(worths > worths.max() - 1e-9).tolist())
    return found


def seen(state, time_s):
    """Return what a controller sees."""
    queue = np.zeros((1, 12), np.int32)
    queue[0, MOVEMENTS] = state
    shown = np.zeros(1, np.int32)
    return Observation(queue, queue * 0, shown, shown, time_s, np.zeros((1, 12)))


def context(*names):
    """Return what a controller is told, with a stream of chance of that name."""
    return RunContext(grid(1, 1), SignalTiming(), stream(0, "two queues", *names))


def drive(controller, arrivals, run, decisions):
    """Let a controller decide; return the states it met, and the mean of vehicles that stayed."""
    controller.reset(context("exploration", run))
    rng = stream(0, "two queues", "arrivals", run)
    state, reward, met, stayed = (0, 0), None, [], []
    for k in range(decisions):
        state = joined(state, arrivals[rng.integers(len(arrivals))])
        met.append(state)
        state = served(state, int(controller.decide(seen(state, 10 * k), reward)[0]))
        stayed.append(sum(state))
        reward = np.array([-float(stayed[-1])])
    return met, np.mean(stayed)


def wrong_states(controller, arrivals, states):
    """Return those of some states in which a frozen controller's choice is not among the best."""
    best = best_phases(arrivals)
    controller.reset(context("judged"))
    return [
        state
        for state in sorted(set(states))
        if int(controller.decide(seen(state, 0), None)[0]) not in best[state]
    ]


def trained(make, options, arrivals, *, decisions, runs=4):
    """Train a controller; return it frozen, and the states that it met."""
    options = {**options, "training_decisions": decisions}
    learner, met = make(options), []
    for run in range(runs):
        met += drive(learner, arrivals, run, decisions // runs)[0]
    frozen = make({**options, "learning": False})
    frozen.reset(context("frozen"))
    frozen.restore(learner.arrays())
    return frozen, met
