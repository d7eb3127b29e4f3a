"""Symmetry: groups of relabellings, embeddings, equivalence classes."""

from dmil.symmetry.classes import Classes, build_classes, embed, vary
from dmil.symmetry.embedding import EMBEDDINGS, Embedding, embedding
from dmil.symmetry.group import SymmetryGroup, find_group

__all__ = [
    "EMBEDDINGS",
    "Classes",
    "Embedding",
    "SymmetryGroup",
    "build_classes",
    "embed",
    "embedding",
    "find_group",
    "vary",
]
