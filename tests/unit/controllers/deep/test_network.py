"""Networks and Adam against torch's own; one thread; torch that is not there."""

import subprocess
import sys
from itertools import pairwise

import numpy as np
import pytest
import torch

from dmil.controllers import make_controller
from dmil.controllers.deep.network import Adam, Mlp, one_thread
from dmil.errors import MissingExtraError
from dmil.seeding import stream


def torchs(network, sizes):
    """Return torch's own network with the same weights."""
    layers = [torch.nn.Linear(of, to) for of, to in pairwise(sizes)]
    parts = torch.split(network.weights.detach(), network._parts)
    with torch.no_grad():
        for k, layer in enumerate(layers):
            layer.weight.copy_(parts[2 * k].view_as(layer.weight))
            layer.bias.copy_(parts[2 * k + 1])
    between = [part for layer in layers[:-1] for part in (layer, torch.nn.ReLU())]
    return torch.nn.Sequential(*between, layers[-1])


def test_a_network_and_its_training_are_torchs():
    rng, sizes = stream(0), (5, 7, 6, 3)
    mine = Mlp(sizes, rng)
    adam = Adam(mine.weights, 1e-2)
    other = torchs(mine, sizes)
    others = torch.optim.Adam(other.parameters(), lr=1e-2)
    for _ in range(50):
        inputs = torch.from_numpy(rng.normal(size=(4, 5)).astype(np.float32))
        goal = torch.from_numpy(rng.normal(size=(4, 3)).astype(np.float32))
        assert torch.allclose(mine(inputs), other(inputs), atol=1e-4)
        adam.minimise(torch.nn.functional.mse_loss(mine(inputs), goal))
        others.zero_grad()
        torch.nn.functional.mse_loss(other(inputs), goal).backward()
        others.step()
    flat = torch.cat([weights.flatten() for weights in other.parameters()])
    assert torch.allclose(mine.weights, flat, atol=1e-4)


def test_first_weights_are_drawn_as_torch_draws_them():
    network = Mlp((100, 50, 8), stream(1))
    matrix, bias, matrix_2, bias_2 = torch.split(network.weights.detach(), network._parts)
    for part, inputs in ((matrix, 100), (bias, 100), (matrix_2, 50), (bias_2, 50)):
        assert part.abs().max() <= inputs**-0.5
    assert matrix.abs().max() > 0.099
    assert abs(matrix.std().item() - 0.1 / 3**0.5) < 2e-3
    assert torch.equal(network.weights, Mlp((100, 50, 8), stream(1)).weights)


def test_other_weights_than_its_own():
    network, other = Mlp((2, 4, 1), stream(1)), Mlp((2, 4, 1), stream(2))
    inputs = torch.ones(3, 2)
    assert torch.equal(network(inputs, other.weights), other(inputs))


def test_one_thread_inside_and_as_many_as_before_outside():
    before = torch.get_num_threads()
    torch.set_num_threads(2)
    try:
        with one_thread():
            assert torch.get_num_threads() == 1
        assert torch.get_num_threads() == 2
        with pytest.raises(ValueError), one_thread():
            raise ValueError
        assert torch.get_num_threads() == 2
    finally:
        torch.set_num_threads(before)


def test_without_torch_one_command_mends_it(monkeypatch):
    for name in [name for name in sys.modules if name.startswith("dmil.controllers.deep.")]:
        if not name.endswith("settings"):
            monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "torch", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'dmil\[deep\]'"):
        make_controller("dqn")


def test_torch_is_not_loaded_before_it_is_needed():
    code = "import sys, dmil.cli, dmil.controllers; sys.exit('torch' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0
