"""Lanes that queue together, in plain Python."""

import numpy as np

from tests.differential.plain_silence import PlainSilence

SINGLE = np.float32


class Lanes:
    """Lanes that queue together: their movements, and what an intersection remembers of them."""

    def __init__(self, node, members):
        movements = [node.movements[j] for j in members]
        self.node, self.members, self.link = node, members, movements[0].from_link
        self.count = len({lane for movement in movements for lane in movement.lanes})
        self.rate, self.rated, self.last = SINGLE(0.5), 0, None
        self.outside, self.silence = SINGLE(0), PlainSilence()

    @property
    def waiting(self):
        return float(self.queue + self.expected)


def groups_of(node):
    """Return the signalled movements of an intersection, those that share lanes together."""
    groups = [{j} for j in range(len(node.movements)) if j not in node.unsignalled]

    def lanes(group):
        return {(node.movements[j].from_link, k) for j in group for k in node.movements[j].lanes}

    while True:
        pairs = [(a, b) for a in groups for b in groups if a is not b and lanes(a) & lanes(b)]
        if not pairs:
            return [Lanes(node, sorted(group)) for group in sorted(groups, key=min)]
        one, other = pairs[0]
        groups = [group for group in groups if group is not one and group is not other]
        groups.append(one | other)
