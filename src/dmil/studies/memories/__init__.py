"""The study of memories: every controller, on grids and recorded cities, under one protocol."""

from dmil.studies.memories.settings import MemoriesStudySettings
from dmil.studies.memories.study import MemoriesStudy

__all__ = ["MemoriesStudy", "MemoriesStudySettings"]
