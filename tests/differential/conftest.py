"""Classes in plain Python; junctions of several shapes, queues that grow by chance on them."""

import numpy as np
import pytest

from dmil.network import Intersection, Link, Movement, RoadNetwork, grid
from dmil.seeding import stream


class PlainClasses:
    """States, keys and symmetries of one shape of intersection."""

    def __init__(self, embedding, group):
        self.embedding = embedding
        elements = group.size if self.embedding.rotations else 1
        self.places = group.movement_image[:elements].tolist()
        self.place_before = np.argsort(self.places, axis=1)
        self.actions = group.phase_image[:elements].tolist()
        self.action_count = len(self.actions[0])

    def key(self, state):
        state = [int(x) for x in state[: len(self.places[0])]]
        levels, largest = self.embedding.scale_levels, max(state)
        scaled = state
        if levels and largest:
            # The floor of levels · x / largest + ½, in whole numbers.
            scaled = [(2 * levels * x + largest) // (2 * largest) for x in state]
        both = state + scaled if self.embedding.also_unscaled else scaled
        return tuple((x + self.embedding.cell_offset) // self.embedding.cell_width for x in both)

    def parts(self, key):
        """Return the parts of a key, each as long as the state."""
        places = len(self.places[0])
        return [key[start : start + places] for start in range(0, len(key), places)]

    def find(self, keys, key):
        """Return index and image of the actions of the nearest key, the oldest, the first."""
        candidates, places = [], len(self.places[0])
        known, key = np.array(keys, dtype=int), np.array(key)
        for start in range(0, len(key) if keys else 0, places):
            moved = key[start : start + places][self.place_before]
            off = np.abs(known[:, np.newaxis, start : start + places] - moved)
            for row, variant in np.argwhere(off.max(2) <= self.embedding.tolerance).tolist():
                candidates.append((start, off[row, variant].sum(), row, variant))
        if not candidates:
            return None, self.actions[0]
        *_, row, variant = min(candidates)
        return row, self.actions[variant]

    def find_or_append(self, rows, key, new_row):
        row, image = self.find([r["key"] for r in rows], key)
        if row is None:
            rows.append({"key": key, **new_row})
            return rows[-1], self.actions[0]
        return rows[row], image


def y_junction(name):
    """Return three like sides, each with a phase of its own: three rotations, three phases."""
    sides = [f"{name}{side}" for side in "ABC"]
    links = [Link(f"{a}>{b}", a, b, 0.0, 10.0, 2) for s in sides for a, b in ((s, name), (name, s))]
    movements = [
        Movement(f"{sides[s]}>{name}", f"{name}>{sides[(s + k) % 3]}", turn, s, (0,))
        for s in range(3)
        for k, turn in ((1, "right"), (2, "left"))
    ]
    phases = tuple(frozenset({2 * s, 2 * s + 1}) for s in range(3))
    return links, Intersection(name, tuple(movements), phases, frozenset()), sides


def mixed_network():
    """Return junctions of three and four sides: Y, X, Y, X."""
    crossings = grid(1, 2)
    links, nodes, fringe = list(crossings.links), list(crossings.intersections), crossings.fringe
    for place, name in ((0, "P"), (2, "Q")):
        more, node, sides = y_junction(name)
        links += more
        nodes.insert(place, node)
        fringe = (*fringe, *sides)
    return RoadNetwork("mixed", tuple(links), tuple(nodes), fringe, {})


def random_walk(network, seed):
    """Return queues, and a step: they grow by chance and shrink where they are served.

    Few vehicles come, and now and then many: states recur, and are not always the same.
    """
    rng = stream(seed, "walk")
    sizes = [len(node.movements) for node in network.intersections]
    queue = np.zeros((len(sizes), max(sizes)), np.int32)

    def step(actions):
        before = queue.copy()
        for i, node in enumerate(network.intersections):
            mean = 0.5 if rng.random() < 0.2 else 0.05
            queue[i, : sizes[i]] += rng.poisson(mean, sizes[i]).astype(np.int32)
            served = sorted(node.phases[actions[i]] | node.unsignalled)
            queue[i, served] = np.maximum(queue[i, served] - 4, 0)
        return -np.sum((queue - before) * np.abs(queue - before), axis=1) / 7.0

    return queue, step


@pytest.fixture(scope="session")
def networks():
    """Return networks of equal and of mixed junctions."""
    return {"grid": grid(2, 2), "mixed": mixed_network()}


@pytest.fixture(scope="session")
def walk():
    """Return a function of a network and a seed: the queues, and how they go on from actions."""
    return random_walk


@pytest.fixture(scope="session")
def plain_classes():
    """Return the twin of embeddings and look-ups."""
    return PlainClasses
