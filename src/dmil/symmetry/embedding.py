"""Embeddings: which states share one memory entry.

An embedding is data. A state becomes a key in two steps, scale and cells, each of which may be
off; two keys then belong to one class if a symmetry of the intersection carries one to within a
tolerance of the other. An embedding that scales may also keep the state as it was before scaling:
then two states belong to one class if they match either way. The paper's classes and ours are
values of these fields, and so is one of your own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from dmil.errors import InputError, unknown_name
from dmil.importing import import_object


@dataclass(frozen=True, slots=True)
class Embedding:
    """How states are grouped into equivalence classes (paper, §IV-A; specification, §5).

    Parameters
    ----------
    name
        What results call it.
    scale_levels
        B in y = ⌊B·x/max(x) + ½⌋ (scale invariance); 0 leaves the counts as they are.
    cell_width, cell_offset
        y = ⌊(x + offset) / width⌋; width 1 and offset 0 leave the counts as they are.
    rotations
        Whether states that a symmetry of the intersection carries into each other share an entry.
    tolerance
        Largest difference in any orientation (L∞) between a state's key and the key it belongs to.
        With a tolerance above 0 the relation is not transitive: the first key wins, so classes
        depend on the order of arrival.
    also_unscaled
        Whether states that are within the tolerance of each other before scaling match, too, and
        first. Only with scale levels and a tolerance: without one, equal states are equal scaled.
    """

    name: str
    scale_levels: int = 0
    cell_width: int = 1
    cell_offset: int = 0
    rotations: bool = False
    tolerance: int = 0
    also_unscaled: bool = False

    @property
    def parts(self) -> int:
        """Of how many parts a key consists, each as long as the state: a match in one is enough."""
        return 2 if self.also_unscaled else 1

    def changed(self, scale_levels: int | None, tolerance: int | None) -> Embedding:
        """Return the same with another B and tolerance, where it scales and has one (ours).

        Parameters
        ----------
        scale_levels, tolerance
            None leaves its own.
        """
        return replace(
            self,
            scale_levels=(scale_levels or self.scale_levels) if self.scale_levels else 0,
            tolerance=(tolerance or self.tolerance) if self.tolerance else 0,
        )

    def __post_init__(self) -> None:
        for field, least in (
            ("scale_levels", 0),
            ("cell_width", 1),
            ("cell_offset", 0),
            ("tolerance", 0),
        ):
            value = getattr(self, field)
            if not isinstance(value, int) or isinstance(value, bool) or value < least:
                raise InputError(
                    f"{field} is {value!r}",
                    where=f"embedding '{self.name}'",
                    expected=f"a whole number of at least {least}",
                )
        if self.also_unscaled and not (self.scale_levels and self.tolerance):
            raise InputError(
                f"also_unscaled with scale_levels {self.scale_levels}, tolerance {self.tolerance}",
                where=f"embedding '{self.name}'",
                expected="scale_levels and tolerance of at least 1 beside also_unscaled",
            )


EMBEDDINGS = {
    embedding.name: embedding
    for embedding in (
        Embedding("exact"),
        Embedding("simple", tolerance=1),
        Embedding("complex", scale_levels=5, rotations=True, tolerance=1, also_unscaled=True),
        Embedding("complex-scaled", scale_levels=5, rotations=True, tolerance=1),
        Embedding("cells", cell_width=3, cell_offset=1),
    )
}
"""The named embeddings: exact and cells are ours, simple and complex the paper's.

The paper's complex embedding *adds* rotation and scale to simple, so two states that simple has in
one class are in one class under complex, too. complex-scaled is the narrower reading: the tolerance
holds after scaling only, which tells an empty road from one vehicle.
"""


def embedding(name: str) -> Embedding:
    """Return an embedding by its name, or by ``package.module:NAME`` one of your own (ours).

    Raises
    ------
    InputError
        If there is none.
    """
    if ":" in name:
        own = import_object(name, "embedding")
        if not isinstance(own, Embedding):
            raise InputError(
                f"it is a {type(own).__name__}",
                where=f"embedding '{name}'",
                expected="a dmil.Embedding",
            )
        return own
    if name not in EMBEDDINGS:
        raise unknown_name("embedding", name, EMBEDDINGS)
    return EMBEDDINGS[name]
