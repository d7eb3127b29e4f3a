"""Studies: many runs, planned, run in parallel, kept and resumed."""

from dmil.studies.executors import EXECUTORS, Executor, LocalExecutor, RayExecutor, make_executor
from dmil.studies.paper import run_paper_study, study_identity
from dmil.studies.settings import PRESETS, PaperStudySettings, Preset

__all__ = [
    "EXECUTORS",
    "PRESETS",
    "Executor",
    "LocalExecutor",
    "PaperStudySettings",
    "Preset",
    "RayExecutor",
    "make_executor",
    "run_paper_study",
    "study_identity",
]
