"""What holds for every sequence of decisions: bounds of memories, the first key wins."""

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from dmil.controllers import RunContext
from dmil.controllers.tabular.agents import classes_of
from dmil.controllers.tabular.dual_memory import DualMemoryController
from dmil.controllers.tabular.sarsa import SarsaController
from dmil.controllers.tabular.settings import DualMemorySettings, SarsaSettings
from dmil.memory import ABSENT, append, look_up, make_rows, make_scratch
from dmil.network import grid
from dmil.scenarios import SignalTiming
from dmil.seeding import stream
from dmil.simulation import Observation
from dmil.symmetry import EMBEDDINGS, Embedding, embed

NETWORK = grid(1, 2)
ACTIONS = 8
EMBEDDING = st.sampled_from(sorted(EMBEDDINGS))
QUEUES = st.lists(
    st.lists(st.integers(0, 3), min_size=12, max_size=12), min_size=2, max_size=6
).map(lambda states: np.array(states, np.int32))
"""A few states that agents come back to."""


def steps(states, order):
    """Yield observations of two agents and rewards."""
    for k, (first, second, reward) in enumerate(order):
        queue = states[[first % len(states), second % len(states)]]
        empty = np.zeros(2, np.int32)
        seen = Observation(queue, np.zeros_like(queue), empty, empty, 10 * k, np.zeros(queue.shape))
        yield seen, None if k == 0 else np.array([reward, -reward])


ORDER = st.lists(
    st.tuples(st.integers(0, 9), st.integers(0, 9), st.floats(-10, 10)), min_size=1, max_size=40
)


@settings(max_examples=60)
@given(
    embedding=EMBEDDING,
    capacity=st.integers(1, 6),
    ratio=st.floats(0.05, 1.0),
    period=st.integers(0, 8),
    staging=st.sampled_from(["value", "visits"]),
    communication=st.booleans(),
    states=QUEUES,
    order=ORDER,
)
def test_bounds_of_the_dual_memory(
    embedding, capacity, ratio, period, staging, communication, states, order
):
    controller = DualMemoryController(
        DualMemorySettings(
            embedding=embedding,
            short_capacity=capacity,
            staged_ratio=ratio,
            stage_period=period,
            staging=staging,
            communication=communication,
            communication_period_s=70,
            epsilon=0.5,
        )
    )
    controller.reset(RunContext(NETWORK, SignalTiming(), stream(1)))
    short, long = np.zeros(2, int), np.zeros(2, int)
    for observation, reward in steps(states, order):
        controller.decide(observation, reward)
        memory = controller.memory
        now_short, now_long = memory.short.rows.size.copy(), memory.long.rows.size.copy()
        # Full means staged and emptied: after a decision there is always room.
        assert (now_short < capacity).all()
        met = communication and observation.time_s % 70 == 0 and observation.time_s > 0
        if not met:
            staged = now_long > long
            assert (now_long - long <= math.ceil(ratio * capacity)).all()
            # Long-term memory grows only where short-term memory was emptied.
            assert (now_short[staged] == 0).all()
            assert ((now_short - short <= 1) | staged).all()
        short, long = now_short, now_long
        use = controller.memory_use()
        assert use.msize == (3 * long + ACTIONS * short).mean()
        # What agents have in common through the central unit counts once.
        everything = (short + long).sum()
        once = everything - (len(long) - 1) * long.min() if communication else everything
        assert once <= use.entries_total <= everything
        assert communication or use.entries_total == everything
        for owner in range(2):
            rows = memory.short.rows.size[owner]
            # Every row holds something, nothing is left beyond the rows.
            assert memory.short.tried[owner, :rows].any(axis=1).all()
            assert not memory.short.tried[owner, rows:].any()
            assert not memory.short.value[owner][~memory.short.tried[owner]].any()
            assert not memory.short.visits[owner, rows:].any()
            if period:
                assert memory.short.visits[owner].sum() < period
            actions = memory.long.action[owner, : long[owner]]
            assert ((actions >= 0) & (actions < ACTIONS)).all()


@settings(max_examples=40)
@given(embedding=EMBEDDING, shared=st.booleans(), states=QUEUES, order=ORDER)
def test_bounds_of_the_q_table(embedding, shared, states, order):
    controller = SarsaController(SarsaSettings(embedding=embedding, shared=shared, epsilon=0.5))
    controller.reset(RunContext(NETWORK, SignalTiming(), stream(1)))
    learned = 0
    for observation, reward in steps(states, order):
        before = controller.table.rows.size.copy()
        controller.decide(observation, reward)
        table = controller.table
        learned += reward is not None
        grown = table.rows.size - before
        assert (grown >= 0).all() and (grown <= (2 if shared else 1)).all()
        # One write per agent and decision that learns, each to one action of one row.
        assert table.visits.sum() == 2 * learned
        assert (table.rows.size <= min(2 * learned, len(states) * (2 - shared))).all()
        assert controller.memory_use().msize == ACTIONS * table.rows.size.mean()


@settings(max_examples=150)
@given(
    levels=st.integers(0, 6),
    width=st.integers(1, 3),
    offset=st.integers(0, 2),
    rotations=st.booleans(),
    tolerance=st.integers(0, 2),
    states=st.lists(
        st.lists(st.integers(0, 40), min_size=12, max_size=12), min_size=1, max_size=30
    ),
)
def test_the_first_key_wins(levels, width, offset, rotations, tolerance, states):
    """A state founds a class only if no older one takes it; founders find themselves for ever."""
    own = Embedding("own", levels, width, offset, rotations, tolerance)
    classes = classes_of(NETWORK, own)
    scratch = make_scratch(classes)
    rows = make_rows(1, len(states), 12, tolerance)
    founders = []
    for state in states:
        key = founder_key(classes, state, scratch)
        row, _ = look_up(rows, classes, 0, 0, key, scratch)
        if row == ABSENT:
            founders.append(key)
            append(rows, 0, key)
        for age, old in enumerate(founders):
            assert look_up(rows, classes, 0, 0, old, scratch) == (age, 0)
    images = classes.movement_image[0, : classes.variant_count[0]]
    for age, key in enumerate(founders):
        for old in founders[:age]:
            for image in images:
                moved = np.zeros(12, np.int32)
                moved[image] = key
                assert np.abs(moved - old).max() > tolerance


def founder_key(classes, state, scratch):
    embed(classes, np.array(state, np.int32), scratch.key)
    return scratch.key.copy()


@settings(max_examples=40)
@given(
    kind=st.sampled_from(["sarsa", "dual-memory"]),
    embedding=EMBEDDING,
    states=QUEUES,
    order=ORDER,
    more=ORDER,
)
def test_what_was_saved_goes_on_as_what_was_not(kind, embedding, states, order, more):
    options = {"embedding": embedding, "epsilon": 0.3, "communication": True}
    if kind == "sarsa":
        pair = [SarsaController(SarsaSettings(**options)) for _ in range(2)]
    else:
        chosen = DualMemorySettings(**options, short_capacity=4)
        pair = [DualMemoryController(chosen) for _ in range(2)]
    original, copy = pair
    original.reset(RunContext(NETWORK, SignalTiming(), stream(1)))
    for observation, reward in steps(states, order):
        original.decide(observation, reward)
    copy.reset(RunContext(NETWORK, SignalTiming(), stream(1)))
    copy.restore(original.arrays())
    for controller in pair:
        controller.reset(RunContext(NETWORK, SignalTiming(), stream(2)))
    for observation, reward in steps(states, more):
        expected = original.decide(observation, reward).tolist()
        assert copy.decide(observation, reward).tolist() == expected
    for name, array in original.arrays().items():
        assert copy.arrays()[name].tobytes() == array.tobytes()
