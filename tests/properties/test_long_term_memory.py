"""What holds for a long-term memory under a cap, whatever agents meet."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from dmil.controllers import RunContext
from dmil.controllers.tabular.dual_memory import DualMemoryController
from dmil.controllers.tabular.settings import DualMemorySettings
from dmil.memory import (
    ABSENT,
    admit,
    frequency,
    look_up,
    make_admission,
    make_rows,
    make_scratch,
    mark_of,
    record,
)
from dmil.memory.admission import HIGHEST, SAMPLE
from dmil.scenarios import SignalTiming
from dmil.seeding import stream
from dmil.symmetry import EMBEDDINGS, Embedding, SymmetryGroup, build_classes
from tests.properties.test_memory import EMBEDDING, NETWORK, ORDER, QUEUES, steps

ALONE = SymmetryGroup(np.arange(4, dtype=np.int32)[None], np.arange(2, dtype=np.int32)[None])
EXACT = build_classes(Embedding("exact"), [ALONE], [0])
OPTIONS = st.fixed_dictionaries(
    {
        "embedding": EMBEDDING,
        "long_capacity": st.integers(1, 5),
        "short_capacity": st.integers(1, 3),
        "staging": st.sampled_from(["value", "visits"]),
        "least_tried": st.integers(1, 3),
        "unseen": st.sampled_from(["random", "longest-queue", "nearest"]),
        "communication": st.booleans(),
    }
)


def new(options, seed=1):
    controller = DualMemoryController(
        DualMemorySettings(**options, epsilon=0.3, communication_period_s=40)
    )
    controller.reset(RunContext(NETWORK, SignalTiming(), stream(seed)))
    return controller


@settings(max_examples=60)
@given(options=OPTIONS, states=QUEUES, order=ORDER)
def test_there_are_never_more_rows_than_the_cap(options, states, order):
    controller = new(options)
    classes = EMBEDDINGS[options["embedding"]]
    scratch = make_scratch(controller._classes)
    for observation, reward in steps(states, order):
        controller.decide(observation, reward)
        rows, use = controller.memory.long.rows, controller.memory_use()
        assert (rows.size <= options["long_capacity"]).all()
        assert use.long_term_entries <= options["long_capacity"]
        for agent in range(2):
            for row in range(rows.size[agent]):
                key = rows.keys[agent, row].copy()
                assert look_up(rows, controller._classes, agent, 0, key, scratch) == (row, 0)
        # A row replaced by one agent is no longer counted as common.
        common = int(controller._common[0])
        assert (rows.keys[0, :common] == rows.keys[1, :common]).all()
    assert rows.tolerance == classes.tolerance


@settings(max_examples=40)
@given(options=OPTIONS, states=QUEUES, order=ORDER, more=ORDER)
def test_a_restored_memory_goes_on_byte_for_byte(options, states, order, more):
    original, copy = new(options), new(options)
    for observation, reward in steps(states, order):
        original.decide(observation, reward)
    copy.restore(original.arrays())
    for controller in (original, copy):
        controller.reset(RunContext(NETWORK, SignalTiming(), stream(2)))
    for observation, reward in steps(states, more):
        expected = original.decide(observation, reward).tolist()
        assert copy.decide(observation, reward).tolist() == expected
    arrays = original.arrays()
    assert {"admission.counts", "admission.recorded", "admission.hand"} <= set(arrays)
    for name, array in arrays.items():
        assert copy.arrays()[name].tobytes() == array.tobytes()


class Cache:
    """Exact keys of one owner under a cap."""

    def __init__(self, capacity):
        self.rows, self.admission = make_rows(1, capacity, 4, 0), make_admission(1, capacity)
        self.scratch = make_scratch(EXACT)

    def mark(self, key):
        return mark_of(EXACT, 0, key, 0, self.scratch)

    def meet(self, key):
        record(self.admission, 0, self.mark(key))
        if not self.holds(key):
            admit(self.rows, self.admission, EXACT, 0, 0, key, self.scratch)

    def holds(self, key):
        return look_up(self.rows, EXACT, 0, 0, key, self.scratch)[0] != ABSENT

    def frequency(self, key):
        return frequency(self.admission, 0, self.mark(key))


@settings(max_examples=60)
@given(capacity=st.integers(4, 60), share=st.floats(0.1, 1.0), seed=st.integers(0, 999))
def test_frequent_keys_survive_a_scan_of_keys_that_come_once(capacity, share, seed):
    rng = stream(seed, "scan")
    cache = Cache(capacity)
    keys = np.unique(rng.integers(0, 1000, (8 * capacity, 4), np.int32), axis=0)
    rng.shuffle(keys)
    often = keys[: max(1, int(share * capacity))]
    for _ in range(8):
        for key in often:
            cache.meet(key)
    # Longer than the memory is large, so that recency alone would forget everything.
    for key in keys[len(often) : len(often) + 4 * capacity]:
        cache.meet(key)
    assert all(cache.holds(key) for key in often)


@settings(max_examples=40)
@given(capacity=st.integers(2, 60), seed=st.integers(0, 999))
def test_what_comes_now_displaces_what_came_long_ago(capacity, seed):
    rng = stream(seed, "change")
    cache = Cache(capacity)
    old, now = np.unique(rng.integers(0, 1000, (2 * capacity + 9, 4), np.int32), axis=0)[
        rng.permutation(2 * capacity)
    ].reshape(2, capacity, 4)
    for keys, rounds in ((old, 15), (now, 60)):
        for _ in range(rounds):
            for key in keys:
                cache.meet(key)
    kept = sum(cache.holds(key) for key in now)
    # Halving makes the old ones forgotten; a counter shared with a new one may keep one of them.
    assert kept >= 0.9 * capacity


@settings(max_examples=60)
@given(
    capacity=st.integers(1, 20),
    met=st.lists(st.integers(0, 30), min_size=1, max_size=200),
)
def test_a_frequency_is_never_too_low(capacity, met):
    cache, counts, recorded = Cache(capacity), dict.fromkeys(range(31), 0), 0
    for k in met:
        record(cache.admission, 0, cache.mark(np.full(4, k, np.int32)))
        counts[k] = min(counts[k] + 1, HIGHEST)
        recorded += 1
        if recorded == SAMPLE * capacity:
            recorded //= 2
            counts = {key: count // 2 for key, count in counts.items()}
        for key, count in counts.items():
            assert count <= cache.frequency(np.full(4, key, np.int32)) <= HIGHEST
