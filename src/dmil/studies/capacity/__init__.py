"""The study of capacity: which load each controller holds, and how it stands disturbances."""

from dmil.studies.capacity.settings import CapacityStudySettings
from dmil.studies.capacity.study import CapacityStudy

__all__ = ["CapacityStudy", "CapacityStudySettings"]
