"""Deep Q-network with prioritised replay (Schaul et al. 2016, proportional variant).

See docs/controllers/dqn-prioritised.md.
"""

from __future__ import annotations

import numpy as np

from dmil.arrays import Array, Arrays, LongArray, Single
from dmil.controllers.deep.dqn import Batch, DqnController
from dmil.controllers.deep.settings import PrioritisedSettings
from dmil.controllers.protocol import RunContext
from dmil.memory.saved import named, part
from dmil.memory.sum_tree import Priorities


class PrioritisedController(DqnController):
    """DQN that replays a transition the more often, the larger its last error was.

    Differs from the paper: plain Q-learning targets, not Double DQN's, so that replay is all that
    differs from ``dqn``; weights are divided by the largest of the batch.

    Parameters
    ----------
    settings
        See `PrioritisedSettings`.
    """

    settings: PrioritisedSettings

    def __init__(self, settings: PrioritisedSettings | None = None) -> None:
        super().__init__(settings or PrioritisedSettings(), name="dqn-prioritised")

    def _start(self, context: RunContext) -> None:
        super()._start(context)
        settings = self.settings
        self._priorities = [
            Priorities(
                settings.buffer_capacity, settings.priority_exponent, settings.priority_floor
            )
            for _ in self._replays
        ]

    def _sample(self, shape: int) -> Batch:
        settings = self.settings
        beta = settings.weight_first + self._training_done * (
            settings.weight_last - settings.weight_first
        )
        draws = self._rng.random(settings.batch_size)
        size = self._replays[shape].size
        rows, weight = self._priorities[shape].sample(draws, size, beta)
        return self._batch(shape, rows, weight.astype(np.float32))

    def _remembered(self, shape: int, rows: LongArray) -> None:
        self._priorities[shape].add(rows)

    def _learned(self, shape: int, rows: LongArray, error: Single) -> None:
        self._priorities[shape].update(rows, error)

    def _bytes(self, shape: int) -> int:
        return super()._bytes(shape) + self._priorities[shape].sums.nbytes

    def _arrays_of(self, shape: int) -> dict[str, Array]:
        size = self._replays[shape].size
        priorities = named("priorities", self._priorities[shape].arrays(size))
        return {**super()._arrays_of(shape), **priorities}

    def _restore_of(self, shape: int, arrays: Arrays) -> None:
        super()._restore_of(shape, arrays)
        size = self._replays[shape].size
        self._priorities[shape].restore(part("priorities", arrays), size)
