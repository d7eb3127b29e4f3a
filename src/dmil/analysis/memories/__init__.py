"""Tables of the study of memories: standing, cost, learning, claims."""

from dmil.analysis.memories.study import MemoriesTables, memories_tables

__all__ = ["MemoriesTables", "memories_tables"]
