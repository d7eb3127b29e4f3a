"""Two lanes before one signal where who approaches comes too late for this green.

So vehicles approaching are no reason to turn green for them, though the factored memory's prior
takes each for one that waits. So few states that the best choices can be computed.
"""

from functools import cache
from itertools import product

import numpy as np

from dmil.controllers import RunContext
from dmil.network import grid
from dmil.scenarios import SignalTiming
from dmil.seeding import stream
from dmil.simulation import Observation

MOST_VEH = 3
NETWORK = grid(1, 1)
MOVEMENTS = (1, 8)
PHASES = range(len(NETWORK.intersections[0].phases))
SERVED = [tuple(j in phase for j in MOVEMENTS) for phase in NETWORK.intersections[0].phases]
"""Which of the two lanes a phase empties; none empties both."""
COMING = ((2, 0), (0, 2), (2, 1), (1, 2), (1, 0), (0, 1))
"""Vehicles that approach the two lanes, all equally likely."""
STATES = tuple(product(product(range(MOST_VEH + 1), repeat=2), COMING))


def left_over(queue, phase):
    """Return who waits in an interval with this phase."""
    return tuple(0 if goes else n for goes, n in zip(SERVED[phase], queue, strict=True))


def joined(queue, coming):
    """Return the queues when those who approached have come."""
    return tuple(min(n + more, MOST_VEH) for n, more in zip(queue, coming, strict=True))


@cache
def best_phases(discount):
    """Return which phases are best in each state, by value iteration."""
    value = dict.fromkeys(STATES, 0.0)
    after = {(*state, phase): left_over(state[0], phase) for state in STATES for phase in PHASES}
    after = {key: (-sum(stays), joined(stays, key[1])) for key, stays in after.items()}

    def worth(*key):
        reward, queue = after[key]
        return reward + discount * mean[queue]

    def mean_values():
        queues = {queue for queue, _ in STATES}
        return {q: sum(value[q, coming] for coming in COMING) / len(COMING) for q in queues}

    for _ in range(150):
        mean = mean_values()
        value = {state: max(worth(*state, phase) for phase in PHASES) for state in STATES}
    found, mean = {}, mean_values()
    for state in STATES:
        worths = {phase: worth(*state, phase) for phase in PHASES}
        most = max(worths.values()) - 1e-9
        found[state] = {phase for phase in PHASES if worths[phase] > most}
    return found


def begin(controller):
    """Begin a run before one intersection of the paper."""
    controller.reset(RunContext(NETWORK, SignalTiming(), stream(0)))


def choice(controller, state, shown=0, waited=(0, 0)):
    """Return the phase that a controller chooses in a state."""
    queue, approaching = np.zeros((2, 1, 12), np.int32)
    queue[0, list(MOVEMENTS)], approaching[0, MOVEMENTS] = state
    waiting = np.zeros((1, 12))
    waiting[0, MOVEMENTS] = waited
    phase = np.array([shown], np.int32)
    return int(
        controller.decide(Observation(queue, approaching, phase, phase, 0, waiting), None)[0]
    )


def wrong_states(controller, discount):
    """Return the states in which vehicles wait and a frozen controller's choice is not the best."""
    best = best_phases(discount)
    begin(controller)
    states = [state for state in STATES if any(state[0])]
    return [state for state in states if choice(controller, state) not in best[state]]


def show_at_random(controller, decisions):
    """Let a controller learn from states that its choices do not change."""
    begin(controller)
    rng = stream(0, "late arrivals", "at random")
    shown, waited = -1, (0, 0)
    for _ in range(decisions):
        queue, coming = (tuple(rng.integers(most + 1, size=2).tolist()) for most in (MOST_VEH, 2))
        shown = choice(controller, (queue, coming), shown, waited)
        waited = left_over(queue, shown)


class Best:
    """Chooses best: what is possible."""

    def reset(self, context):
        self.best = best_phases(0.9)

    def decide(self, seen, reward):
        counts = seen.queue_veh, seen.approaching_veh
        state = tuple(tuple(count[0, list(MOVEMENTS)].tolist()) for count in counts)
        return np.array([min(self.best[state])], np.int32)


def drive(controller, decisions):
    """Let a controller decide and learn; return how many waited in the mean."""
    begin(controller)
    rng = stream(0, "late arrivals")
    state, shown, waited = ((0, 0), COMING[0]), -1, (0, 0)
    total = 0
    for _ in range(decisions):
        shown = choice(controller, state, shown, waited)
        waited = left_over(state[0], shown)
        total += sum(waited)
        state = joined(waited, state[1]), COMING[rng.integers(len(COMING))]
    return total / decisions
