"""The paper's study: its plan, tables, claims, figures and page."""

from dmil.studies.paper.settings import PRESETS, PaperStudySettings, Preset
from dmil.studies.paper.study import PaperStudy

__all__ = ["PRESETS", "PaperStudy", "PaperStudySettings", "Preset"]
