"""The ablation: each part of our controllers switched off or on alone, on the same vehicles."""

from dmil.studies.ablation.settings import AblationStudySettings
from dmil.studies.ablation.study import AblationStudy

__all__ = ["AblationStudy", "AblationStudySettings"]
