"""The doctor: what was understood of a network and its demand, and what is wrong with them."""

from dmil.doctor.case import Case, read_case
from dmil.doctor.diagnosis import Diagnosis, NetworkFacts, examine
from dmil.doctor.findings import SEVERITIES, Finding
from dmil.doctor.intersections import IntersectionFacts
from dmil.doctor.kinds import KINDS, kinds_markdown
from dmil.doctor.load import Load
from dmil.doctor.traffic import Traffic

__all__ = [
    "KINDS",
    "SEVERITIES",
    "Case",
    "Diagnosis",
    "Finding",
    "IntersectionFacts",
    "Load",
    "NetworkFacts",
    "Traffic",
    "examine",
    "kinds_markdown",
    "read_case",
]
