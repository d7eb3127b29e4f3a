"""Which relabellings of an intersection's sides leave everything as it was."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations

import numpy as np
import numpy.typing as npt

from dmil.arrays import IntArray

MOST_SIDES = 7
"""Above this many sides (5,040 relabellings) only the identity is offered."""


@dataclass(frozen=True, slots=True)
class SymmetryGroup:
    """A group of relabellings acting on the movements and phases of an intersection.

    Attributes
    ----------
    movement_image: (elements, movements) int32
        Element g carries what movement j held to movement ``movement_image[g, j]``.
    phase_image: (elements, phases) int32
        A phase p chosen before the relabelling is phase ``phase_image[g, p]`` after it.
    """

    movement_image: IntArray
    phase_image: IntArray

    @property
    def size(self) -> int:
        """Number of elements; the identity is the first."""
        return len(self.movement_image)


def find_group(
    origin: npt.ArrayLike, goal: npt.ArrayLike, turn: npt.ArrayLike, served: npt.ArrayLike
) -> SymmetryGroup:
    """Find the symmetries of an intersection (specification, §5; the paper assumes 4 rotations).

    A permutation of the sides is a symmetry if it maps every movement onto a movement of the same
    turn, and every phase onto a phase. The paper's intersection has exactly its four rotations: a
    mirror would turn left turns into right turns.

    Parameters
    ----------
    origin, goal: (movements,) int
        Side that a movement comes from and side that it leaves by, numbered 0, 1, …
    turn: (movements,) int or str
        Kind of turn.
    served: (phases, movements) bool
        Movements that a phase serves.
    """
    origins, goals = np.asarray(origin), np.asarray(goal)
    turns, phases = np.asarray(turn), np.asarray(served, np.bool_)
    sides = int(max(origins.max(), goals.max())) + 1
    place = {
        key: j
        for j, key in enumerate(zip(origins.tolist(), goals.tolist(), turns.tolist(), strict=True))
    }
    phase_place = {row.tobytes(): p for p, row in enumerate(phases)}
    identity = tuple(range(sides))
    # Movements or phases that cannot be told apart leave no unique image.
    unique = len(place) == origins.size and len(phase_place) == len(phases)
    candidates = permutations(range(sides)) if unique and sides <= MOST_SIDES else [identity]
    movement_images, phase_images = [], []
    for sides_image in candidates:
        keys = zip(
            (sides_image[side] for side in origins),
            (sides_image[side] for side in goals),
            turns.tolist(),
            strict=True,
        )
        image = [place.get(key, -1) for key in keys] if unique else list(range(origins.size))
        if -1 in image:
            continue
        moved = np.empty_like(phases)
        moved[:, image] = phases
        phase_image = [phase_place.get(row.tobytes(), -1) for row in moved]
        if not unique:
            phase_image = list(range(len(phases)))
        if -1 not in phase_image:
            movement_images.append(image)
            phase_images.append(phase_image)
    return SymmetryGroup(np.array(movement_images, np.int32), np.array(phase_images, np.int32))
