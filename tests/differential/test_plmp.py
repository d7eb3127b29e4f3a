"""Pattern classes, PLMP's decisions and its predictions against plain Python."""

import math

import numpy as np
import pytest

from dmil.controllers import RunContext, make_controller
from dmil.controllers.tabular.announcements import Announcements
from dmil.controllers.tabular.choice import DRAWS
from dmil.memory import append, make_rows
from dmil.memory.patterns import PROBE, find_pattern
from dmil.network import grid
from dmil.scenarios import SignalTiming
from dmil.seeding import stream
from dmil.simulation import Observation
from dmil.testing.proving_grounds import uneven_network

STEP = 3
"""Every third pair of a key and a pattern is looked at: all keys, and all patterns."""
NETWORKS = {"grid": grid(2, 2), "uneven": uneven_network()}


def plainly_covers(key, pattern, reach):
    """As it is defined: the key, its multiples, and what is 0 … reach above it everywhere."""
    return all(0 <= p - k <= reach for k, p in zip(key, pattern, strict=True)) or any(
        all(p == v * k for k, p in zip(key, pattern, strict=True)) for v in range(2, reach + 1)
    )


def plainly_found(keys, pattern, reach):
    """Return the oldest key that covers a pattern."""
    return next((i for i, k in enumerate(keys) if plainly_covers(k, pattern, reach)), -1)


def covers(key, pattern, reach):
    """Tell whether a table of one key finds it for a pattern."""
    rows = make_rows(1, 1, key.size, 0)
    append(rows, 0, key)
    return find_pattern(rows, 0, pattern[None], reach, np.zeros((1, key.size), np.int32)) == 0


@pytest.mark.parametrize("reach", [0, 1, 2, 3])
def test_classes_are_as_they_are_defined(reach):
    covered = 0
    for code in range(0, 4**3 * 7**3, STEP):
        key = np.array([code % 4, code // 4 % 4, code // 16 % 4], np.int32)
        rest = code // 64
        pattern = np.array([rest % 7, rest // 7 % 7, rest // 49], np.int32)
        expected = plainly_covers(key.tolist(), pattern.tolist(), reach)
        assert covers(key, pattern, reach) == expected
        covered += expected
    # Multiples of keys that are too far for the rest of the class are among them.
    assert covers(np.array([3, 0, 2], np.int32), np.array([9, 0, 6], np.int32), reach) == (
        reach >= 3
    )
    assert 4**3 / STEP <= covered < 4**3 * 7**3 / STEP / 2


@pytest.mark.parametrize("reach", [0, 1, 2, 3])
@pytest.mark.parametrize("places", [3, 8, 16])
def test_the_first_key_that_covers_a_pattern_has_it(places, reach):
    """Two owners; a third of the patterns are multiples of keys, a third are a little above."""
    rng = stream(reach, "patterns", places)
    rows, keys = make_rows(2, 900, places, 0), ([], [])
    key, hits = np.zeros((1, places), np.int32), {"probed": 0, "compared": 0, "divided": 0}
    for number in range(1500 if places == 3 else 900):
        owner = number % 2
        pattern = rng.poisson(2.0, places).astype(np.int32)
        if keys[owner] and number % 3:
            base = np.array(keys[owner][rng.integers(len(keys[owner]))], np.int32)
            multiple = number % 3 == 1
            pattern = base * 2 if multiple else base + rng.integers(0, 2, places, dtype=np.int32)
        row = find_pattern(rows, owner, pattern[None], reach, key)
        assert row == plainly_found(keys[owner], pattern.tolist(), reach)
        if row == -1:
            append(rows, owner, pattern)
            keys[owner].append(pattern.tolist())
        elif keys[owner][row] != pattern.tolist():
            below = np.prod(1.0 + np.minimum(reach, pattern)) * PROBE < len(keys[owner])
            hits["probed" if below else "compared"] += 1
            hits["divided"] += keys[owner][row] == (pattern / 2).tolist()
    assert (hits["divided"] > 20) == (reach >= 2)
    assert (hits["compared"] > 20) == (reach >= 1)
    # Few places: few keys can cover a pattern, and they are looked up.
    assert hits["probed"] > 20 or places > 3 or reach not in (1, 2)


@pytest.mark.parametrize("older", ["half", "below"])
@pytest.mark.parametrize("others", [0, 5000])
def test_of_two_keys_that_cover_a_pattern_the_older_has_it(others, older):
    """By comparing keys, and with many others by looking them up."""
    rows, key = make_rows(1, 5002, 4, 0), np.zeros((1, 4), np.int32)
    pattern = np.array([4, 2, 6, 2], np.int32)
    covering = {"half": pattern // 2, "below": pattern - 1}
    append(rows, 0, covering.pop(older))
    for number in range(others):
        append(rows, 0, np.array([20 + number, 0, 0, 0], np.int32))
    append(rows, 0, covering.popitem()[1])
    assert find_pattern(rows, 0, pattern[None], 2, key) == 0


def plain_ahead(network, seen, timing, flow, *, leaves=True):
    """Return the queues one decision ahead, one movement after the other."""

    def has_green(i, j):
        item, phase = network.intersections[i], int(seen.phase[i])
        return j in item.unsignalled or (phase >= 0 and j in item.phases[phase])

    def goes(i, j, time_s):
        lanes = max(1, len(network.intersections[i].movements[j].lanes))
        return min(seen.queue_veh[i, j], flow * lanes * time_s) if has_green(i, j) else 0

    links = {link.id: link for link in network.links}
    movements = {}
    for item in network.intersections:
        for movement in item.movements:
            movements[movement.from_link] = movements.get(movement.from_link, 0) + 1
    inflow = dict.fromkeys(links, 0.0)
    for i, item in enumerate(network.intersections):
        for j, movement in enumerate(item.movements):
            link = links[movement.to_link]
            in_time_s = max(0, timing.decision_interval_s - link.length_m / link.speed_m_per_s)
            inflow[link.id] += goes(i, j, in_time_s)
    ahead = np.zeros_like(seen.queue_veh)
    for i, item in enumerate(network.intersections):
        for j, movement in enumerate(item.movements):
            comes = seen.approaching_veh[i, j] + inflow[movement.from_link] / movements.get(
                movement.from_link
            )
            stays = seen.queue_veh[i, j] - leaves * goes(i, j, timing.decision_interval_s)
            ahead[i, j] = math.floor(stays + comes + 0.5)
    return ahead


def looks(network, seed, count):
    """Yield observations drawn at random."""
    rng = stream(seed, "looks")
    most = max(len(item.movements) for item in network.intersections)
    phases = [len(item.phases) for item in network.intersections]
    for k in range(count):
        queue = np.zeros((len(phases), most), np.int32)
        coming = queue.copy()
        for i, item in enumerate(network.intersections):
            n = len(item.movements)
            queue[i, :n], coming[i, :n] = rng.poisson(1.2, n), rng.poisson(0.3, n)
        shown = rng.integers(-1, phases).astype(np.int32)
        yield Observation(queue, coming, shown, shown * 0, 10 * k, queue.astype(float))


@pytest.mark.parametrize("name", NETWORKS)
def test_predictions_are_those_of_plain_sums(name):
    network, timing = NETWORKS[name], SignalTiming(decision_interval_s=10)
    context = RunContext(network, timing, stream(0))
    announcements = Announcements(context)
    flow = context.dynamics.saturation_flow_veh_per_s
    for seen in looks(network, 1, 60):
        found = announcements.queue_ahead(seen)
        assert found.tolist() == plain_ahead(network, seen, timing, flow).tolist()
        full = announcements.queue_with_inflow(seen, seen.phase)
        assert full.tolist() == plain_ahead(network, seen, timing, flow, leaves=False).tolist()


class PlainPlmp:
    """PLMP with lists, agent by agent."""

    def __init__(self, network, reach, predicts, capacity):
        self.network, self.reach = network, reach
        self.predicts, self.capacity = predicts, capacity
        self.keys, self.values = {}, {}
        self.last = [None] * len(network.intersections)

    def decide(self, patterns, ahead, shapes, reward, draws, epsilon):
        return [
            self.agent(i, shape, patterns[i], ahead[i], reward, draws[i], epsilon)
            for i, shape in enumerate(shapes)
        ]

    def agent(self, i, shape, pattern, ahead, reward, draws, epsilon):
        keys = self.keys.setdefault(shape, [])
        values = self.values.setdefault(shape, [])
        row = known = plainly_found(keys, pattern, self.reach)
        if row < 0 and self.predicts:
            known = plainly_found(keys, ahead, self.reach)
        tried = values[known] if known >= 0 else {}
        count = len(self.network.intersections[i].phases)
        if self.last[i] is not None and reward is not None:
            then, phase = self.last[i]
            old = then.get(phase, 0.0)
            following = max(tried.values()) if tried else 0.0
            then[phase] = old + 0.1 * (reward[i] + 0.95 * following - old)
        if known < 0 or draws[0] < epsilon:
            action = int(draws[1] * count)
        else:
            worth = [tried.get(phase, 0.0) for phase in range(count)]
            best = [phase for phase in range(count) if worth[phase] == max(worth)]
            action = best[int(draws[2] * len(best))]
        if row < 0 and len(keys) < self.capacity:
            row = len(keys)
            keys.append(pattern)
            values.append({})
        self.last[i] = (values[row], action) if row >= 0 else None
        return action


@pytest.mark.parametrize("predicts", [True, False])
@pytest.mark.parametrize("capacity", [15, 1000])
@pytest.mark.parametrize("name", NETWORKS)
def test_decisions_are_those_of_the_plain_twin(name, capacity, predicts):
    network = NETWORKS[name]
    options = {"reach": 1, "prediction": predicts, "capacity": capacity, "epsilon_last": 0.2}
    options |= {"epsilon_first": 0.2}
    controller = make_controller("plmp", options)
    controller.reset(RunContext(network, SignalTiming(), stream(5, "chance")))
    twin = PlainPlmp(network, 1, predicts, capacity)
    chance, rewards, reward = stream(5, "chance"), stream(5, "rewards"), None
    announcements = Announcements(RunContext(network, SignalTiming(), stream(5)))
    shapes = controller.agents.shape.tolist()
    for seen in looks(network, 2, 120):
        patterns = controller.states(seen).tolist()
        ahead = controller.signalled(announcements.queue_ahead(seen)).tolist()
        draws = chance.random((len(shapes), DRAWS))
        expected = twin.decide(patterns, ahead, shapes, reward, draws, 0.2)
        assert controller.decide(seen, reward).tolist() == expected
        reward = rewards.standard_normal(len(shapes))
    stored = [keys for _, keys in sorted(twin.keys.items())]
    assert controller.arrays()["size"].tolist() == [len(keys) for keys in stored]
    assert controller.arrays()["keys"].tolist() == [key for keys in stored for key in keys]
    values = [each for _, values in sorted(twin.values.items()) for each in values]
    for found, tried, expected in zip(
        controller.arrays()["value"], controller.arrays()["tried"], values, strict=True
    ):
        assert {int(p): found[p] for p in np.flatnonzero(tried)} == expected
    counts = controller.lookups()
    assert sum(counts.values()) == 120 * len(shapes)
    assert (counts["prediction"] > 0) == predicts
