"""What the deep controllers share of torch: networks with flat weights, Adam, one thread."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import numpy.typing as npt
import torch

from dmil.arrays import Array, Arrays, Single
from dmil.controllers.deep.settings import DqnSettings
from dmil.memory.saved import saved_array

ADAM_BETAS = (0.9, 0.999)
ADAM_EPSILON = 1e-8


class Mlp:
    """A network of fully connected layers with ReLU in between, all its weights in one array.

    One flat array makes copying, saving and a step of the optimiser one operation each; for
    networks as small as these, operations cost more than numbers.

    Parameters
    ----------
    sizes
        Neurons of each layer, inputs and outputs included, such as ``(12, 64, 64, 8)``.
    rng
        Draws the first weights: uniform within ±1/√inputs for weights and biases, as torch does.
    """

    def __init__(self, sizes: tuple[int, ...], rng: np.random.Generator) -> None:
        self._shapes = list(zip(sizes[1:], sizes[:-1], strict=True))
        self._parts = [n for to, of in self._shapes for n in (to * of, to)]
        drawn = [rng.uniform(-1, 1, to * (of + 1)) / np.sqrt(max(of, 1)) for to, of in self._shapes]
        flat = np.concatenate(drawn).astype(np.float32)
        self.weights = torch.from_numpy(flat).requires_grad_()

    def __call__(self, inputs: Any, weights: Any = None) -> Any:
        """Return the outputs of a batch.

        Parameters
        ----------
        inputs: (batch, inputs) float32 tensor
        weights: (weights,) float32 tensor, optional
            Other weights than its own, such as those of a target network.

        Returns
        -------
        outputs: (batch, outputs) float32 tensor
        """
        parts = torch.split(self.weights if weights is None else weights, self._parts)
        last = len(self._shapes) - 1
        for layer, shape in enumerate(self._shapes):
            matrix, bias = parts[2 * layer].view(shape), parts[2 * layer + 1]
            inputs = torch.addmm(bias, inputs, matrix.t())
            if layer < last:
                inputs = torch.relu(inputs)
        return inputs


class Adam:
    """Adam (Kingma & Ba 2015, Algorithm 1) on one flat array of weights.

    Parameters
    ----------
    weights: (weights,) float32 tensor
        Changed in place.
    learning_rate
        α.
    """

    def __init__(self, weights: Any, learning_rate: float) -> None:
        self.weights = weights
        self.learning_rate = learning_rate
        self.mean = torch.zeros_like(weights, requires_grad=False)
        self.square = torch.zeros_like(weights, requires_grad=False)
        self.steps = 0

    def minimise(self, loss: Any) -> None:
        """Take one step down a loss, a scalar tensor that came from the weights."""
        self.step(torch.autograd.grad(loss, self.weights)[0])

    def step(self, gradient: Any) -> None:
        """Take one step against a gradient: (weights,) float32 tensor."""
        self.steps += 1
        one, two = ADAM_BETAS
        with torch.no_grad():
            self.mean.lerp_(gradient, 1 - one)
            self.square.mul_(two).addcmul_(gradient, gradient, value=1 - two)
            scale = (1 - two**self.steps) ** 0.5
            divisor = self.square.sqrt().add_(ADAM_EPSILON * scale)
            rate = self.learning_rate * scale / (1 - one**self.steps)
            self.weights.addcdiv_(self.mean, divisor, value=-rate)

    def arrays(self) -> dict[str, Array]:
        """Return weights, moments and steps as flat arrays."""
        return {
            "weights": to_array(self.weights),
            "mean": to_array(self.mean),
            "square": to_array(self.square),
            "steps": np.array(self.steps, np.int64),
        }

    def restore(self, arrays: Arrays) -> None:
        """Replace weights, moments and steps.

        Raises
        ------
        PolicyError
            If the arrays are not those of as many weights.
        """
        steps = int(saved_array(arrays, "steps", (), np.int64, least=0))
        for name, tensor in (
            ("weights", self.weights),
            ("mean", self.mean),
            ("square", self.square),
        ):
            overwrite(tensor, arrays, name)
        self.steps = steps


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


def to_array(tensor: Any) -> Single:
    """Return a copy of a tensor as an array (ours)."""
    array: Single = tensor.detach().numpy().copy()
    return array


def overwrite(tensor: Any, arrays: Arrays, name: str) -> None:
    """Replace the numbers of a tensor by saved ones (ours).

    Raises
    ------
    PolicyError
        If they are missing, not as many, of another type or not finite.
    """
    array = saved_array(arrays, name, tuple(tensor.shape), np.float32)
    with torch.no_grad():
        tensor.copy_(torch.from_numpy(np.ascontiguousarray(array)))


@contextmanager
def one_thread() -> Iterator[None]:
    """Let torch use one thread inside, and as many as before afterwards (ours).

    With more threads the sums of a matrix product are split differently, so the last bits would
    depend on the machine's cores; and for networks as small as these a second thread only costs.
    """
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(before)
