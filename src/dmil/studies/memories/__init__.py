"""The study of memories: every controller, on grids and recorded cities, under one protocol."""

from dmil.studies.memories.run import memories_identity, run_memories_study
from dmil.studies.memories.settings import MemoriesStudySettings

__all__ = ["MemoriesStudySettings", "memories_identity", "run_memories_study"]
