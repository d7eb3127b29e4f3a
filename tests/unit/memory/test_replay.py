"""The ring of transitions against a queue of Python; what it saves; what it refuses."""

from collections import deque

import numpy as np
import pytest

from dmil.errors import PolicyError
from dmil.memory.replay import Replay, Runs
from dmil.seeding import stream

COLUMNS = {"state": (np.uint16, (3,)), "reward": (np.float32, ())}


def block(rng, rows):
    return {
        "state": rng.integers(0, 9, (rows, 3)).astype(np.uint16),
        "reward": rng.random(rows).astype(np.float32),
    }


def content(replay):
    """Return the rows from the oldest to the newest, as pairs of tuple and number."""
    rows = np.arange(replay.written - replay.size, replay.written) % replay.capacity
    states, rewards = replay.take("state", rows), replay.take("reward", rows)
    return list(zip(map(tuple, states.tolist()), rewards.tolist(), strict=True))


@pytest.mark.parametrize("capacity", [1, 5, 16])
def test_a_ring_is_a_queue_of_limited_length(capacity):
    rng = stream(capacity, "blocks")
    replay, plain = Replay(capacity, COLUMNS), deque(maxlen=capacity)
    for _ in range(40):
        rows = block(rng, int(rng.integers(0, 8)))
        places = replay.append(**rows)
        stored = list(zip(map(tuple, rows["state"].tolist()), rows["reward"].tolist(), strict=True))
        plain.extend(stored)
        assert content(replay) == list(plain)
        assert replay.size == len(plain)
        assert len(places) == min(len(stored), capacity)
        for place, (state, reward) in zip(places, stored[-capacity:], strict=True):
            assert tuple(replay.take("state", place)) == state
            assert replay.take("reward", place) == np.float32(reward)
    assert replay.bytes_used == replay.size * (3 * 2 + 4)


def test_every_row_in_use_is_equally_likely():
    replay = Replay(50, COLUMNS)
    replay.append(**block(stream(1), 7))
    draws = (np.arange(7000) + 0.5) / 7000
    assert np.bincount(replay.sample(draws)).tolist() == [1000] * 7
    assert replay.sample(np.array([0.0, np.nextafter(1, 0)])).tolist() == [0, 6]


@pytest.mark.parametrize("rows", [3, 12])
def test_a_saved_ring_goes_on_as_the_old_one(rows):
    old, new, rng = Replay(8, COLUMNS), Replay(8, COLUMNS), stream(2)
    old.append(**block(rng, rows))
    new.append(**block(rng, 5))  # restoring replaces, it does not append
    saved = old.arrays()
    assert len(saved["state"]) == min(rows, 8)
    new.restore(saved)
    for _ in range(3):
        assert content(new) == content(old)
        more = block(rng, 3)
        assert old.append(**more).tolist() == new.append(**more).tolist()
    assert saved["written"] == rows


@pytest.mark.parametrize(
    ("name", "array"),
    [
        ("written", None),
        ("written", np.array(-1)),
        ("written", np.array(7)),
        ("state", None),
        ("state", np.zeros((6, 3), np.int32)),
        ("state", np.zeros((6, 2), np.uint16)),
        ("reward", np.full(6, np.nan, np.float32)),
    ],
)
def test_what_is_no_such_ring_is_refused_and_changes_nothing(name, array):
    replay = Replay(8, COLUMNS)
    replay.append(**block(stream(3), 6))
    before, wrong = content(replay), replay.arrays()
    wrong.pop(name)
    if array is not None:
        wrong[name] = array
    with pytest.raises(PolicyError, match=name if array is None else "array"):
        replay.restore(wrong)
    assert content(replay) == before


class PlainRuns:
    """All rows ever written, each with its run."""

    def __init__(self):
        self.run, self.of = -1, []

    def begin(self):
        self.run += 1

    def future(self, number, draw):
        later = [n for n in range(number, len(self.of)) if self.of[n] == self.of[number]]
        return later[int(draw * len(later))]


@pytest.mark.parametrize("capacity", [4, 30])
def test_the_future_of_a_row_is_in_its_own_run(capacity):
    rng, runs, plain, written = stream(capacity, "runs"), Runs(capacity), PlainRuns(), 0
    for _ in range(25):
        runs.begin(written)
        plain.begin()
        for _ in range(int(rng.integers(0, 9))):
            plain.of.append(plain.run)
            written += 1
            numbers = np.arange(max(0, written - capacity), written)
            draws = rng.random(numbers.size)
            found = runs.future(numbers % capacity, draws, written)
            expected = [plain.future(n, d) % capacity for n, d in zip(numbers, draws, strict=True)]
            assert found.tolist() == expected
        assert runs.begins.size <= capacity + 2 or written < capacity
        copy = Runs(capacity)
        copy.restore(runs.arrays(), written)
        assert copy.begins.tolist() == runs.begins.tolist()


def test_runs_that_cannot_belong_to_the_ring_are_refused():
    runs = Runs(4)
    for wrong in ([3, 1], [0, 9], [2, 3]):
        with pytest.raises(PolicyError, match="begins"):
            runs.restore({"begins": np.array(wrong)}, written=5)
    with pytest.raises(PolicyError, match="begins"):
        runs.restore({}, written=5)
