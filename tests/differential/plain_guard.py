"""The guard for shared lanes in plain Python: sets and dictionaries, one movement at a time."""

import math


class PlainGuard:
    """Sees which lanes are stuck; `owed` are the vehicles that green for a movement counts more."""

    def __init__(self, network, interval_s):
        self.network, self.interval_s = network, interval_s
        self.evidence = dict.fromkeys(range(len(network.intersections)), 0.0)
        self.red_s, self.before, self.owed = {}, {}, {}

    def shares(self, node, j, k):
        one, other = node.movements[j], node.movements[k]
        lanes = set(one.lanes) & set(other.lanes) if one.from_link == other.from_link else set()
        return lanes and any((j in phase) != (k in phase) for phase in node.phases)

    def look(self, seen):
        for i, node in enumerate(self.network.intersections):
            self.evidence[i] *= math.exp(-self.interval_s / 1000)
            green = node.phases[seen.phase[i]] if seen.phase[i] >= 0 else frozenset()
            movements = set(range(len(node.movements))) - node.unsignalled
            queue = {j: int(seen.queue_veh[i, j]) for j in movements}
            shared = {j: {k for k in movements if self.shares(node, j, k)} for j in movements}
            for j in movements:
                was_green, was_queue = self.before.get((i, j), (False, 0))
                waits = any(queue[k] and k not in green for k in shared[j])
                if j in green and was_green and 0 < was_queue <= queue[j] and waits:
                    self.evidence[i] = 1.0
                red_s = self.red_s.get((i, j), 0) + self.interval_s
                self.red_s[i, j] = 0 if j in green or not queue[j] else red_s
                self.before[i, j] = j in green, queue[j]
            for j in movements:
                self.owed[i, j] = self.evidence[i] * 0.2 * self.red_s[i, j] if shared[j] else 0.0
