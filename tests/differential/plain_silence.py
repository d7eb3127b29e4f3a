"""Detectors that fall silent, in plain Python: a lane remembers how many came before."""

import numpy as np

SINGLE = np.float32
RED = 0
LEAST, TIMES, UNNOTICED, MOST = 12, 3, SINGLE(10), SINGLE(20)


class PlainSilence:
    """What one lane group remembers of its detector."""

    def __init__(self):
        self.now, self.longest, self.dead = 0, 0, False
        self.thousandths = 0

    def listen(self, group, treated, discharged):
        """Take in a count; return the vehicles queued from memory, None if the detector is alive.

        How the group was treated in the interval that ended, and who could leave in it.
        """
        before = group.last[2]
        if group.queue + group.moving > 0:
            longest = TIMES * self.longest if self.dead else max(self.longest, self.now, 1)
            self.now, self.longest, self.dead = 0, min(84, longest), False
        elif self.longest and not self.dead:
            self.now += 1
            if self.now > max(LEAST, TIMES * self.longest):
                self.dead = True
                before = UNNOTICED * SINGLE(self.thousandths) / SINGLE(1000)
        if not self.dead:
            if self.longest and treated == RED:
                joined = SINGLE(1000) * max(SINGLE(0), group.queue - before)
                self.thousandths += int((joined - SINGLE(self.thousandths)) / SINGLE(16))
            return None
        rate = SINGLE(self.thousandths) / SINGLE(1000)
        now = min(MOST, max(SINGLE(0), before + rate - discharged))
        group.waited = float(before + now) / 2
        return now
