"""Studies: many runs, planned, run in parallel, kept and resumed."""

from dmil.studies.executors import EXECUTORS, Executor, LocalExecutor, RayExecutor, make_executor
from dmil.studies.memories import (
    MemoriesStudySettings,
    memories_identity,
    run_memories_study,
)
from dmil.studies.paper import run_paper_study, study_identity
from dmil.studies.resco import RescoStudySettings, resco_identity, run_resco_study
from dmil.studies.settings import PRESETS, PaperStudySettings, Preset
from dmil.studies.warm_up import compile_kernels

__all__ = [
    "EXECUTORS",
    "PRESETS",
    "Executor",
    "LocalExecutor",
    "MemoriesStudySettings",
    "PaperStudySettings",
    "Preset",
    "RayExecutor",
    "RescoStudySettings",
    "compile_kernels",
    "make_executor",
    "memories_identity",
    "resco_identity",
    "run_memories_study",
    "run_paper_study",
    "run_resco_study",
    "study_identity",
]
