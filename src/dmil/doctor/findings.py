"""One thing that was found, and what is said of every sort of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Severity = Literal["error", "warning", "note"]
SEVERITIES: tuple[Severity, ...] = ("error", "warning", "note")


@dataclass(frozen=True, slots=True)
class Kind:
    """A sort of finding (ours).

    Parameters
    ----------
    severity
        How bad it usually is: an error makes results wrong, a warning makes them doubtful, a note
        is good to know.
    meaning
        What it says about the files, whole sentences.
    mend
        What to do about it, whole sentences.
    """

    severity: Severity
    meaning: str
    mend: str


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that was found (ours).

    Parameters
    ----------
    kind
        One of the keys of `dmil.doctor.kinds.KINDS`.
    severity
        How bad it is here.
    place
        Where, without the file's name.
    what
        What was found there.
    mend
        What to do about it.
    """

    kind: str
    severity: Severity
    place: str
    what: str
    mend: str
