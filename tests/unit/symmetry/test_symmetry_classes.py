"""Embeddings against their literal formulas, and what an embedding may not be."""

import math
from fractions import Fraction

import numpy as np
import pytest

from dmil.controllers.tabular.agents import classes_of
from dmil.errors import InputError, UnknownNameError
from dmil.network import grid
from dmil.seeding import stream
from dmil.symmetry import (
    EMBEDDINGS,
    Embedding,
    SymmetryGroup,
    build_classes,
    embed,
    embedding,
    vary,
)

PAPER = grid(1, 1)


def key_of(classes, state):
    key = np.full(classes.parts * len(state), -7, np.int32)
    embed(classes, np.array(state, np.int32), key)
    return key.tolist()


def states(count=3000):
    """Draw states from empty to far beyond saturation."""
    rng = stream(1, "states")
    load = rng.choice([0.2, 1.0, 4.0, 30.0, 1e5], (count, 1))
    drawn = rng.poisson(load * rng.random((count, 12)))
    drawn[:3] = [[0], [1], [2**30]]
    return drawn.tolist()


@pytest.mark.parametrize("name", ["exact", "simple"])
def test_counts_are_left_as_they_are(name):
    classes = classes_of(PAPER, EMBEDDINGS[name])
    for state in states(300):
        assert key_of(classes, state) == state


@pytest.mark.parametrize("levels", [1, 2, 5, 7, 100])
def test_scale_is_rounded_half_up(levels):
    """⌊B·x/max(x) + ½⌋, 0 if empty: with whole numbers, where floats would err at halves."""
    classes = classes_of(PAPER, Embedding("scaled", scale_levels=levels))
    for state in states(1000):
        expected = [
            math.floor(Fraction(levels * x, max(state)) + Fraction(1, 2)) if any(state) else 0
            for x in state
        ]
        assert key_of(classes, state) == expected


def test_the_papers_scale_has_five_levels():
    classes = classes_of(PAPER, EMBEDDINGS["complex-scaled"])
    state = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 10]
    assert key_of(classes, state) == [0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 5]
    assert key_of(classes, [0] * 12) == [0] * 12
    # Scale invariance: any multiple has the same key.
    for factor in (2, 3, 17):
        assert key_of(classes, [factor * x for x in state]) == key_of(classes, state)


def test_the_papers_complex_key_is_the_state_and_the_state_scaled():
    classes = classes_of(PAPER, EMBEDDINGS["complex"])
    scaled = classes_of(PAPER, EMBEDDINGS["complex-scaled"])
    for state in states(300):
        assert key_of(classes, state) == state + key_of(scaled, state)


def test_both_parts_of_a_key_have_cells():
    classes = classes_of(
        PAPER,
        Embedding(
            "both",
            scale_levels=10,
            cell_width=4,
            cell_offset=2,
            tolerance=1,
            also_unscaled=True,
        ),
    )
    for state in states(300):
        scaled = [math.floor(Fraction(20 * x + max(state), 2 * max(max(state), 1))) for x in state]
        assert key_of(classes, state) == [(x + 2) // 4 for x in state + scaled]


def test_cells_are_three_wide_around_the_multiples_of_three():
    classes = classes_of(PAPER, EMBEDDINGS["cells"])
    for state in states(1000):
        assert key_of(classes, state) == [(x + 1) // 3 for x in state]
    assert key_of(classes, list(range(12))) == [0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3, 4]


def test_scale_comes_before_cells():
    classes = classes_of(
        PAPER, Embedding("both", scale_levels=10, cell_width=4, cell_offset=2, tolerance=1)
    )
    for state in states(300):
        scaled = [math.floor(Fraction(20 * x + max(state), 2 * max(max(state), 1))) for x in state]
        assert key_of(classes, state) == [(y + 2) // 4 for y in scaled]


def test_variants_are_the_rotations_of_a_key():
    classes = classes_of(PAPER, EMBEDDINGS["complex-scaled"])
    key = np.arange(12, dtype=np.int32)
    variants = np.full((4, 12), -1, np.int32)
    assert vary(classes, 0, key, variants) == 4
    assert variants[0].tolist() == key.tolist()
    assert {tuple(row) for row in variants.tolist()} == {
        tuple(np.roll(key, 3 * turn).tolist()) for turn in range(4)
    }
    # Two parts turn together.
    classes, both = classes_of(PAPER, EMBEDDINGS["complex"]), np.full((4, 24), -1, np.int32)
    assert vary(classes, 0, np.append(key, 100 + key), both) == 4
    assert both.tolist() == [[*row, *(100 + row)] for row in variants]


@pytest.mark.parametrize("name", ["exact", "simple", "cells"])
def test_without_rotations_the_key_is_its_only_variant(name):
    classes = classes_of(PAPER, EMBEDDINGS[name])
    variants = np.full((4, 12), -1, np.int32)
    assert vary(classes, 0, np.arange(12, dtype=np.int32), variants) == 1
    assert variants.tolist() == [list(range(12)), *[[-1] * 12] * 3]


def test_shapes_of_other_sizes_stand_side_by_side():
    swap = SymmetryGroup(np.array([[0, 1], [1, 0]], np.int32), np.array([[0], [0]], np.int32))
    alone = SymmetryGroup(np.arange(3, dtype=np.int32)[None], np.arange(4, dtype=np.int32)[None])
    classes = build_classes(Embedding("turned", rotations=True), [swap, alone], [1, 0, 0])
    assert classes.shape.tolist() == [1, 0, 0]
    assert classes.movement_count.tolist() == [2, 3]
    assert classes.phase_count.tolist() == [1, 4]
    assert classes.variant_count.tolist() == [2, 1]
    # Beyond its own movements a shape leaves everything in place.
    assert classes.movement_image[0].tolist() == [[0, 1, 2], [1, 0, 2]]
    variants = np.zeros((2, 3), np.int32)
    assert vary(classes, 0, np.array([5, 6, 0], np.int32), variants) == 2
    assert variants.tolist() == [[5, 6, 0], [6, 5, 0]]
    assert vary(classes, 1, np.array([5, 6, 7], np.int32), variants) == 1


def test_a_phase_and_its_image_lead_to_each_other():
    classes = classes_of(PAPER, EMBEDDINGS["complex"])
    image, preimage = classes.phase_image[0], classes.phase_preimage[0]
    for variant in range(4):
        assert image[variant][preimage[variant]].tolist() == list(range(8))
        assert preimage[variant][image[variant]].tolist() == list(range(8))


@pytest.mark.parametrize("field", ["scale_levels", "cell_width", "cell_offset", "tolerance"])
@pytest.mark.parametrize("value", [-1, 1.5, True, "2", None])
def test_fields_are_whole_numbers(field, value):
    with pytest.raises(InputError) as error:
        Embedding("odd", **{field: value})
    assert f"embedding 'odd': {field} is {value!r}" in str(error.value)
    assert "whole number" in str(error.value)


def test_a_cell_has_a_width():
    with pytest.raises(InputError, match="cell_width is 0"):
        Embedding("flat", cell_width=0)


@pytest.mark.parametrize("fields", [{"tolerance": 1}, {"scale_levels": 5}, {}])
def test_also_unscaled_needs_a_scale_and_a_tolerance(fields):
    with pytest.raises(InputError, match="also_unscaled with"):
        Embedding("odd", also_unscaled=True, **fields)


def test_embeddings_have_names():
    assert {name: embedding(name).name for name in EMBEDDINGS} == {n: n for n in EMBEDDINGS}
    with pytest.raises(UnknownNameError, match="Did you mean 'simple'"):
        embedding("simpel")


def test_the_papers_embeddings_are_those_of_the_specification():
    assert EMBEDDINGS["simple"] == Embedding("simple", tolerance=1)
    assert EMBEDDINGS["complex"] == Embedding(
        "complex", scale_levels=5, rotations=True, tolerance=1, also_unscaled=True
    )
    assert EMBEDDINGS["complex-scaled"] == Embedding(
        "complex-scaled", scale_levels=5, rotations=True, tolerance=1
    )
    assert EMBEDDINGS["cells"] == Embedding("cells", cell_width=3, cell_offset=1)
    assert EMBEDDINGS["exact"] == Embedding("exact")


def test_an_embedding_of_ones_own_has_an_import_path():
    path = "dmil.symmetry.embedding:EMBEDDINGS"
    with pytest.raises(InputError, match="it is a dict"):
        embedding(path)
    with pytest.raises(InputError, match="cannot be imported"):
        embedding("no_such_package.at_all:NAME")
