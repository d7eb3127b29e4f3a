"""The study of protocols: published recipes by name, and what a recipe alone is worth."""

from dmil.studies.protocols.settings import ProtocolsStudySettings
from dmil.studies.protocols.study import ProtocolsStudy

__all__ = ["ProtocolsStudy", "ProtocolsStudySettings"]
