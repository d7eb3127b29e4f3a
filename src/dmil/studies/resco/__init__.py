"""The study on the RESCO benchmark: train fast, judge in SUMO, and see whether both agree."""

from dmil.studies.resco.plan import ContenderUnit, units
from dmil.studies.resco.run import resco_identity, run_resco_study
from dmil.studies.resco.settings import RescoStudySettings

__all__ = ["ContenderUnit", "RescoStudySettings", "resco_identity", "run_resco_study", "units"]
