"""Studies: one folder each, with all that is its own; the engine is `dmil.experiments`."""

from dmil.experiments.study import Study, run_study
from dmil.studies.ablation import AblationStudy, AblationStudySettings
from dmil.studies.capacity import CapacityStudy, CapacityStudySettings
from dmil.studies.memories import MemoriesStudy, MemoriesStudySettings
from dmil.studies.paper import PRESETS, PaperStudy, PaperStudySettings, Preset
from dmil.studies.protocols import ProtocolsStudy, ProtocolsStudySettings
from dmil.studies.resco import RescoStudy, RescoStudySettings

__all__ = [
    "PRESETS",
    "AblationStudy",
    "AblationStudySettings",
    "CapacityStudy",
    "CapacityStudySettings",
    "MemoriesStudy",
    "MemoriesStudySettings",
    "PaperStudy",
    "PaperStudySettings",
    "Preset",
    "ProtocolsStudy",
    "ProtocolsStudySettings",
    "RescoStudy",
    "RescoStudySettings",
    "Study",
    "run_study",
]
