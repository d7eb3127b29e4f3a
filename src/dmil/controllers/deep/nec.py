"""Neural episodic control: a learned embedding over a dictionary of returns (Pritzel et al. 2017).

See docs/controllers/nec.md.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import torch

from dmil.arrays import Array, Arrays, FloatArray, IntArray
from dmil.compilation import kernel
from dmil.controllers.deep.learner import NetworkLearner
from dmil.controllers.deep.network import Adam, Mlp, features, one_thread
from dmil.controllers.deep.settings import NecSettings
from dmil.controllers.episodic.by_shape import ReturnWindow, best_tried
from dmil.controllers.protocol import MemoryUse, RunContext
from dmil.memory.episodic import gather, recall_mean, write_towards
from dmil.memory.neighbours import (
    Entries,
    KeyArray,
    Neighbours,
    TimeArray,
    make_entries,
    make_neighbours,
)
from dmil.memory.packing import bytes_of_entries, pack_entries, unpack_entries
from dmil.memory.replay import Replay
from dmil.memory.saved import named, part
from dmil.simulation import Observation


class NecController(NetworkLearner):
    """One agent per intersection; agents of one shape share an embedding and its dictionaries.

    Differs from the paper: the loss moves the embedding only, not the keys and values that are
    stored; the inputs are counts, not pictures.
    """

    settings: NecSettings
    SOURCES = ("neighbours", "untried")
    _entries: Entries

    def __init__(self, settings: NecSettings | None = None) -> None:
        super().__init__("nec", settings or NecSettings())

    def reset(self, context: RunContext) -> None:
        """Get ready for a run; see `SharedLearner.reset`."""
        super().reset(context)
        self._window = ReturnWindow(self.settings.steps, self.settings.discount)

    def decide(self, observation: Observation, reward: FloatArray | None) -> IntArray:
        """Look all phases up, learn the return that is known now, choose ε-greedily.

        Raises
        ------
        DivergedError
            If an embedding, a value or a return is not finite.
        """
        settings, state = self.settings, self.states(observation)
        self._time_s = observation.time_s
        with one_thread():
            key = self._embeddings(state)
            value = self._recalled(key)
            action = self.choose(value, observation)
            if settings.learning:
                if reward is not None:
                    self._learn(reward * settings.reward_scale, best_tried(value))
                self._window.choose(state, key, action)
                self._decisions += 1
        return action

    def memory_use(self) -> MemoryUse:
        """Return how much is remembered now: one entry per embedding and phase."""
        sizes = self._entries.size.reshape(-1, self._actions).sum(axis=1)
        weights = sum(network.weights.numel() for network in self._networks)
        replays = sum(replay.bytes_used for replay in self._replays)
        # Weights, and Adam's two moments of each.
        return self.use_of(sizes, bytes_of_entries(self._entries) + 3 * 4 * weights + replays)

    def arrays(self) -> Arrays:
        """Return dictionaries, networks, moments and what is replayed as flat arrays."""
        saved: dict[str, Array] = named("entries", pack_entries(self._entries))
        for shape, (adam, replay) in enumerate(zip(self._adams, self._replays, strict=True)):
            saved |= named(f"{shape}.network", adam.arrays())
            saved |= named(f"{shape}.replay", replay.arrays())
        return self._with_decisions(saved)

    def restore(self, arrays: Arrays) -> None:
        """Replace dictionaries, networks, moments and what is replayed.

        Raises
        ------
        PolicyError
            If the arrays are not those of the same networks and dictionaries.
        """
        entries = unpack_entries(part("entries", arrays), self._entries)
        for shape, (adam, replay) in enumerate(zip(self._adams, self._replays, strict=True)):
            adam.restore(part(f"{shape}.network", arrays))
            replay.restore(part(f"{shape}.replay", arrays))
        self._take_decisions(arrays)
        self._entries = entries

    def _start(self) -> None:
        settings, shapes = self.settings, len(self.agents.signatures)
        self._actions = int(self._phase_count.max())
        layers = self.places, settings.hidden, settings.embedding
        self._networks = [Mlp(layers, self._rng) for _ in range(shapes)]
        self._adams = [Adam(each.weights, settings.learning_rate) for each in self._networks]
        columns: dict[str, Any] = {
            "state": (np.uint16, (self.places,)),
            "action": (np.int16, ()),
            "outcome": (np.float32, ()),
        }
        self._replays = [Replay(settings.buffer_capacity, columns) for _ in range(shapes)]
        self._entries = make_entries(shapes * self._actions, settings.capacity, settings.embedding)
        self._nearest = make_neighbours(settings.neighbours)

    def _embeddings(self, state: IntArray) -> KeyArray:
        """Return the embeddings of all agents' states: (agents, embedding) float32."""
        key = np.zeros((len(state), self.settings.embedding), np.float32)
        with torch.no_grad():
            for network, members in zip(self._networks, self.agents.members, strict=True):
                key[members] = network(features(state[members])).numpy()
        self._expect_finite(key, "embeddings")
        return key

    def _recalled(self, key: KeyArray) -> FloatArray:
        """Return values: (agents, phases) float64, infinite where a phase was never tried."""
        learning = self.settings.learning
        # Who learns tries everything once; who does not keeps to what was tried.
        value = np.full((len(key), self._actions), np.inf if learning else -np.inf)
        recall_all(
            self._entries,
            self.agents.shape,
            self._phase_count,
            key,
            self.settings.softening,
            self._nearest,
            learning,
            value,
            self._lookups,
        )
        return value

    def _learn(self, reward: FloatArray, following: FloatArray) -> None:
        found = self._window.reward(reward, following)
        if found is not None:
            (state, key, action), outcome = found
            self._expect_finite(outcome, "returns")
            shape = self.agents.shape
            table = (shape * self._actions + action).astype(np.int32)
            write_all(self._entries, table, key, outcome, self.settings.value_rate)
            for each, members in enumerate(self.agents.members):
                self._replays[each].append(
                    state=state[members], action=action[members], outcome=outcome[members]
                )
        if self._decisions % self.settings.train_every == 0:
            self._train()

    def _train(self) -> None:
        """Move each embedding down the squared error of what is replayed."""
        settings = self.settings
        for shape, (network, replay) in enumerate(zip(self._networks, self._replays, strict=True)):
            if replay.size < settings.batch_size:
                continue
            rows = replay.sample(self._rng.random(settings.batch_size))
            embedding = network(features(replay.take("state", rows)))
            key = embedding.detach().numpy()
            self._expect_finite(key, "embeddings")
            table = shape * self._actions + replay.take("action", rows).astype(np.int32)
            value = self._mean(embedding, table, key)
            error = value - torch.from_numpy(replay.take("outcome", rows))
            self._adams[shape].minimise((error * error).mean())

    def _mean(self, embedding: Any, table: IntArray, key: KeyArray) -> Any:
        """Return the neighbours' weighted means, to learn through: (batch,) tensor."""
        batch, count = len(key), self.settings.neighbours
        keys = np.zeros((batch, count, key.shape[1]), np.float32)
        value, present = np.zeros((2, batch, count), np.float32)
        gather(self._entries, table, key, self._nearest, keys, value, present)
        distance = (embedding[:, None] - torch.from_numpy(keys)).square().sum(2)
        weight = torch.from_numpy(present) / (distance + self.settings.softening)
        return (weight * torch.from_numpy(value)).sum(1) / weight.sum(1)


@kernel
def recall_all(
    entries: Entries,
    shape: IntArray,
    phase_count: IntArray,
    key: KeyArray,
    softening: float,
    nearest: Neighbours,
    touches: bool,
    value: FloatArray,
    lookups: TimeArray,
) -> None:
    """Look up the embeddings of all agents under every phase.

    Parameters
    ----------
    entries
        Table shape·actions + action is that of a shape and an action.
    shape, phase_count: (agents,) int32
    key: (agents, embedding) float32
    softening: float
        δ.
    touches
        Whether what is read counts as used.
    value: (agents, actions) float64
        Filled in place where a table has entries.
    lookups: (2,) int64
        Look-ups by `SOURCES`, counted up.
    """
    actions = value.shape[1]
    # Phase by phase: a table stays in the processor's cache while all agents read it.
    for action in range(actions):
        for agent in range(shape.shape[0]):
            if action >= phase_count[agent]:
                continue
            table = shape[agent] * actions + action
            if entries.size[table] == 0:
                lookups[1] += 1
                continue
            mean, _ = recall_mean(entries, table, key[agent], softening, nearest, touches)
            value[agent, action] = mean
            lookups[0] += 1


@kernel
def write_all(
    entries: Entries, table: IntArray, key: KeyArray, outcome: FloatArray, value_rate: float
) -> None:
    """Write the returns of all agents, one after the other."""
    for agent in range(table.shape[0]):
        write_towards(entries, table[agent], key[agent], outcome[agent], value_rate)
