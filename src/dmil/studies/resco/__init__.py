"""The study on the RESCO benchmark: train fast, evaluate in SUMO, and see whether both agree."""

from dmil.studies.resco.settings import RescoStudySettings
from dmil.studies.resco.study import RescoStudy

__all__ = ["RescoStudy", "RescoStudySettings"]
