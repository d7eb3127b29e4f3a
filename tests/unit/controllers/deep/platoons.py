"""Platoons before signals, a problem whose best choice is known in every state."""

import numpy as np

from dmil.controllers import RunContext
from dmil.network import grid
from dmil.scenarios import SignalTiming
from dmil.seeding import stream
from dmil.simulation import Observation

KINDS = 4
MOST_VEH = 40


class Platoons:
    """Every decision a platoon of 3 to 6 vehicles reaches each intersection, on one of 4 movements.

    A queue leaves whole when the phase that belongs to its movement is chosen, and stays
    otherwise: best is always the phase of the longest queue. Which phase belongs to a movement
    differs between intersections, so they cannot share one policy without knowing who they are.
    """

    def __init__(self, intersections=1, *, alike=True):
        self.network = grid(1, intersections)
        first = self.network.intersections[0]
        self.movements = [j for j in range(12) if j not in first.unsignalled][:: 8 // KINDS]
        turn = np.zeros(intersections, int) if alike else np.arange(intersections)
        self.phase_of = (np.arange(KINDS) + turn[:, None]) % KINDS

    def reset(self, controller, seed, run):
        """Begin a run of a controller, and the vehicles of that run."""
        timing = SignalTiming()
        controller.reset(RunContext(self.network, timing, stream(seed, run, "exploration")))
        self.rng = stream(seed, run, "platoons")
        self.queue = np.zeros((len(self.phase_of), KINDS), int)
        self.arrive()

    def arrive(self):
        """Let a platoon arrive at every intersection."""
        each = np.arange(len(self.queue))
        self.queue[each, self.rng.integers(0, KINDS, each.size)] += self.rng.integers(
            3, 7, each.size
        )
        self.queue = np.minimum(self.queue, MOST_VEH)

    def seen(self, time_s):
        """What a controller sees."""
        queue = np.zeros((len(self.queue), 12), np.int32)
        queue[:, self.movements] = self.queue
        phase = np.full(len(queue), -1, np.int32)
        empty = np.zeros_like(queue)
        return Observation(queue, empty, phase, phase * 0, time_s, empty.astype(np.float64))

    def serve(self, phases):
        """Let queues go, and the next platoon come; return what stayed: (intersections,)."""
        for i, phase in enumerate(phases):
            self.queue[i, self.phase_of[i] == phase] = 0
        stayed = self.queue.sum(axis=1)
        self.arrive()
        return stayed

    def is_best(self, phases):
        """Whether each phase is that of the longest queue: (intersections,) bool."""
        longest = self.queue.max(axis=1, keepdims=True)
        best = [self.phase_of[i][self.queue[i] == longest[i]] for i in range(len(phases))]
        return np.array([phase in good for phase, good in zip(phases, best, strict=True)])

    def drive(self, controller, *, runs, decisions=50, seed=0, to_team=False):
        """Let a controller decide; return how often it chose best, what stayed, the worst queues.

        With ``to_team`` the first intersection gets the reward of all, and the others get 0.
        """
        best, stayed, worst = [], [], []
        for run in runs:
            self.reset(controller, seed, run)
            reward = None
            for k in range(decisions):
                phases = controller.decide(self.seen(10 * k), reward)
                best.append(self.is_best(phases))
                stayed.append(self.serve(phases))
                worst.append(self.queue.max(axis=1))
                reward = -stayed[-1].astype(np.float64)
                if to_team:
                    reward = np.append(reward.sum(), 0 * reward[1:])
        return np.mean(best), np.mean(stayed), np.array(worst)
