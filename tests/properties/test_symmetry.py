"""What holds for every symmetry: inverses, classes that rotate as a whole, turned actions."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from dmil.controllers.tabular.agents import agents_of, classes_of
from dmil.memory import look_up, make_scratch, make_value_table, write
from dmil.network import grid
from dmil.symmetry import EMBEDDINGS, Embedding, embed, find_group, vary

NETWORK = grid(1, 1)
GROUP = agents_of(NETWORK).groups[0]
CLASSES = classes_of(NETWORK, EMBEDDINGS["complex-scaled"])
STATE = st.lists(st.integers(0, 60), min_size=12, max_size=12).map(
    lambda state: np.array(state, np.int32)
)
TURN = st.integers(0, 3)


def key_of(classes, state):
    key = np.zeros(classes.parts * 12, np.int32)
    embed(classes, state, key)
    return key


def rotated(state, turn):
    moved = np.zeros(12, np.int32)
    moved[GROUP.movement_image[turn]] = state
    return moved


@given(state=STATE, turn=TURN, levels=st.integers(0, 9), width=st.integers(1, 4))
def test_the_key_of_a_rotated_state_is_the_rotated_key(state, turn, levels, width):
    classes = classes_of(NETWORK, Embedding("own", levels, width, 0, True, 1))
    found = key_of(classes, rotated(state, turn))
    assert found.tolist() == rotated(key_of(classes, state), turn).tolist()


@given(state=STATE, turn=TURN)
def test_the_variants_of_a_rotated_key_are_those_of_the_key(state, turn):
    variants = np.zeros((2, 4, 12), np.int32)
    vary(CLASSES, 0, state, variants[0])
    vary(CLASSES, 0, rotated(state, turn), variants[1])
    assert sorted(variants[0].tolist()) == sorted(variants[1].tolist())


@given(state=STATE, turn=TURN, action=st.integers(0, 7), value=st.floats(-100, 100))
def test_what_is_written_for_a_state_is_read_for_its_rotations(state, turn, action, value):
    scratch = make_scratch(CLASSES)
    table = make_value_table(1, 4, 12, 8, 1)
    write(table, CLASSES, 0, 0, key_of(CLASSES, state), action, value, scratch)
    key = key_of(CLASSES, rotated(state, turn))
    row, variant = look_up(table.rows, CLASSES, 0, 0, key, scratch)
    assert row == 0
    stored = CLASSES.phase_preimage[0, variant, np.flatnonzero(table.tried[0, 0])[0]]
    carried = rotated(key_of(CLASSES, state), turn)
    # Several rotations may carry a state near itself; then any of their actions is as good.
    fitting = [
        GROUP.phase_image[other, action]
        for other in range(4)
        if np.abs(rotated(key_of(CLASSES, state), other) - carried).max() <= 1
    ]
    assert stored in fitting
    if len(fitting) == 1:
        assert stored == GROUP.phase_image[turn, action]
    assert table.value[0, 0].sum() == value


def are_one_class(name, first, second):
    """Whether the second of two states is found under the first."""
    classes = classes_of(NETWORK, EMBEDDINGS[name])
    scratch = make_scratch(classes)
    table = make_value_table(1, 4, classes.parts * 12, 8, classes.tolerance, classes.parts)
    write(table, classes, 0, 0, key_of(classes, first), 0, 1.0, scratch)
    return look_up(table.rows, classes, 0, 0, key_of(classes, second), scratch)[0] == 0


@given(state=STATE, turn=TURN, factor=st.integers(1, 4), off=st.lists(st.integers(-1, 1)))
def test_complex_classes_contain_simple_ones_and_add_rotation_and_scale(state, turn, factor, off):
    near = state.copy()
    near[: len(off)] = np.maximum(near[: len(off)] + off[:12], 0)
    assert are_one_class("simple", state, near)
    assert are_one_class("complex", state, near)
    assert are_one_class("complex", state, rotated(near, turn))
    assert are_one_class("complex", state, rotated((factor * state).astype(np.int32), turn))
    assert are_one_class("complex-scaled", state, factor * state)


def test_the_narrower_reading_tells_an_empty_road_from_one_vehicle():
    empty, one = np.zeros((2, 12), np.int32)
    one[4] = 1
    answers = {name: are_one_class(name, empty, one) for name in EMBEDDINGS}
    assert answers == {
        "exact": False,
        "simple": True,
        "complex": True,
        "complex-scaled": False,
        "cells": True,
    }


@st.composite
def junctions(draw):
    """Draw movements between up to five sides and phases over them."""
    sides = draw(st.integers(2, 5))
    pairs = [(o, g) for o in range(sides) for g in range(sides)]
    chosen = draw(st.lists(st.sampled_from(pairs), min_size=1, max_size=8, unique=True))
    turns = draw(st.lists(st.sampled_from("ab"), min_size=len(chosen), max_size=len(chosen)))
    row = st.lists(st.booleans(), min_size=len(chosen), max_size=len(chosen)).map(tuple)
    phases = draw(st.lists(row, min_size=1, max_size=4, unique=True))
    origin, goal = zip(*chosen, strict=True)
    return list(origin), list(goal), turns, np.array(phases)


@settings(max_examples=200)
@given(junction=junctions())
def test_the_symmetries_of_any_junction_are_a_group(junction):
    origin, goal, turn, served = junction
    group = find_group(origin, goal, turn, served)
    elements = list(zip(group.movement_image.tolist(), group.phase_image.tolist(), strict=True))
    assert elements[0] == (list(range(len(origin))), list(range(len(served))))
    for places, phases in elements:
        assert sorted(places) == list(range(len(origin)))
        assert [turn[j] for j in places] == turn
        for phase, row in enumerate(served):
            assert served[phases[phase]][places].tolist() == row.tolist()
        for others, later in elements:
            product = ([others[j] for j in places], [later[p] for p in phases])
            assert product in elements
    inverses = [[places.index(j) for j in range(len(places))] for places, _ in elements]
    assert all(any(inverse == places for places, _ in elements) for inverse in inverses)
