"""Values of the phases of one shape of intersection: a network, its target network, their steps."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import torch

from dmil.arrays import Array, Arrays, Single
from dmil.controllers.deep.network import Adam, Mlp, overwrite, to_array
from dmil.controllers.deep.settings import DqnSettings


class QNetwork:
    """Q and its target Q⁻, which is a copy of Q from time to time (Mnih et al. 2015).

    Parameters
    ----------
    inputs, phases
        Numbers in a state, and of phases.
    settings
        See `DqnSettings`.
    rng
        Draws the first weights.
    """

    def __init__(
        self, inputs: int, phases: int, settings: DqnSettings, rng: np.random.Generator
    ) -> None:
        self.network = Mlp((inputs, settings.hidden, settings.hidden, phases), rng)
        self.target = self.network.weights.detach().clone()
        self.adam = Adam(self.network.weights, settings.learning_rate)
        self._target_period = settings.target_period

    def values(self, state: npt.NDArray[np.integer]) -> Single:
        """Return Q of all phases.

        Parameters
        ----------
        state: (batch, inputs) int
            Counts.
        """
        with torch.no_grad():
            found: Single = self.network(features(state)).numpy()
        return found

    def value_of(self, state: npt.NDArray[np.integer], action: npt.NDArray[np.integer]) -> Any:
        """Return Q of the phases that were chosen: (batch,) tensor to learn through."""
        chosen = torch.from_numpy(action.astype(np.int64))
        return self.network(features(state)).gather(1, chosen[:, None])[:, 0]

    def best(self, state: npt.NDArray[np.integer]) -> Any:
        """Return the largest Q⁻ of each state: (batch,) tensor."""
        with torch.no_grad():
            return self.network(features(state), self.target).amax(1)

    def learn(self, gradient: Any) -> None:
        """Take one step against a gradient, and renew the target network when it is time."""
        self.adam.step(gradient)
        if self.adam.steps % self._target_period == 0:
            self.target.copy_(self.network.weights.detach())

    @property
    def bytes_used(self) -> int:
        """Memory of both networks and of Adam's moments."""
        return int(4 * self.target.numel() * self.target.element_size())

    def arrays(self) -> dict[str, Array]:
        """Return all numbers as flat arrays."""
        return {**self.adam.arrays(), "target": to_array(self.target)}

    def restore(self, arrays: Arrays) -> None:
        """Replace all numbers.

        Raises
        ------
        PolicyError
            If the arrays are not those of a network of the same layers.
        """
        self.adam.restore(arrays)
        overwrite(self.target, arrays, "target")


def features(state: npt.NDArray[np.integer]) -> Any:
    """Return counts as a network sees them, log(1 + x): float32 tensor of the same shape (ours)."""
    return torch.from_numpy(np.log1p(state, dtype=np.float32))
