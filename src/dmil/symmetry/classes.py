"""Equivalence classes as flat arrays: state → key → symmetric variants of the key, compiled."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dmil.arrays import IntArray
from dmil.compilation import kernel
from dmil.symmetry.embedding import Embedding
from dmil.symmetry.group import SymmetryGroup


class Classes(NamedTuple):
    """An embedding made concrete for the agents of a network.

    Attributes
    ----------
    shape: (agents,) int32
        Which shape of intersection an agent controls.
    movement_count, phase_count, variant_count: (shapes,) int32
        Movements, phases and symmetries of a shape.
    movement_image: (shapes, variants, parts·movements) int32
        Every part of a key is permuted alike.
    phase_image, phase_preimage: (shapes, variants, phases) int32
        The image of a phase under a symmetry, and the phase with that image.
    scale_levels, cell_width, cell_offset, tolerance, parts: int
        See `Embedding`.
    """

    shape: IntArray
    movement_count: IntArray
    phase_count: IntArray
    variant_count: IntArray
    movement_image: IntArray
    phase_image: IntArray
    phase_preimage: IntArray
    scale_levels: int
    cell_width: int
    cell_offset: int
    tolerance: int
    parts: int


def build_classes(
    embedding: Embedding, groups: Sequence[SymmetryGroup], shape: npt.ArrayLike
) -> Classes:
    """Flatten an embedding and the symmetry group of each shape (ours).

    Parameters
    ----------
    embedding
        How states are grouped.
    groups
        Symmetries of each shape of intersection.
    shape: (agents,) int
        Index into ``groups`` for each agent.
    """
    used = [group.size if embedding.rotations else 1 for group in groups]
    movements = [group.movement_image.shape[1] for group in groups]
    phases = [group.phase_image.shape[1] for group in groups]
    variants, most = max(used), max(movements)
    movement_image = np.zeros((len(groups), variants, embedding.parts * most), np.int32)
    phase_image = np.zeros((len(groups), variants, max(phases)), np.int32)
    phase_preimage = np.zeros_like(phase_image)
    movement_image[:] = np.arange(embedding.parts * most)
    for s, group in enumerate(groups):
        for g in range(used[s]):
            for start in range(0, embedding.parts * most, most):
                end = start + movements[s]
                movement_image[s, g, start:end] = start + group.movement_image[g]
            phase_image[s, g, : phases[s]] = group.phase_image[g]
            phase_preimage[s, g, group.phase_image[g]] = np.arange(phases[s])
    return Classes(
        shape=np.asarray(shape, np.int32),
        movement_count=np.array(movements, np.int32),
        phase_count=np.array(phases, np.int32),
        variant_count=np.array(used, np.int32),
        movement_image=movement_image,
        phase_image=phase_image,
        phase_preimage=phase_preimage,
        scale_levels=embedding.scale_levels,
        cell_width=embedding.cell_width,
        cell_offset=embedding.cell_offset,
        tolerance=embedding.tolerance,
        parts=embedding.parts,
    )


@kernel
def embed(classes: Classes, state: IntArray, key: IntArray) -> None:
    """Turn a state into its key: scale, then cells (specification, §5).

    Parameters
    ----------
    state: (movements,) int32
    key: (parts·movements,) int32
        Filled in place; of two parts the first is not scaled.
    """
    levels, width, offset = classes.scale_levels, classes.cell_width, classes.cell_offset
    last = (classes.parts - 1) * state.shape[0]
    largest = 0
    for j in range(state.shape[0]):
        largest = max(largest, state[j])
    for j in range(state.shape[0]):
        value = state[j]
        if last > 0:
            key[j] = (value + offset) // width if width > 1 else value + offset
        # Divisions take most of the time here, so there is none that changes nothing.
        if levels > 0 and value > 0:
            # ⌊B·x/max + ½⌋ in whole numbers, so that no rounding of floats can split a class.
            value = (2 * levels * value + largest) // (2 * largest)
        value += offset
        key[last + j] = value // width if width > 1 else value


@kernel
def vary(classes: Classes, shape: int, key: IntArray, variants: IntArray) -> int:
    """Write the images of a key under every symmetry of its shape; return how many there are.

    Parameters
    ----------
    key: (parts·movements,) int32
    variants: (at least the number of symmetries, parts·movements) int32
        Filled in place; the first is the key itself.
    """
    count = classes.variant_count[shape]
    for g in range(count):
        image = classes.movement_image[shape, g]
        for j in range(key.shape[0]):
            variants[g, image[j]] = key[j]
    return int(count)
