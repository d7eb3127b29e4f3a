"""One thing that was found."""

from __future__ import annotations

from dataclasses import dataclass

from dmil.doctor.kind import Severity
from dmil.doctor.kinds import KINDS


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that was found (ours).

    Parameters
    ----------
    kind
        One of the keys of `KINDS`.
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


def finding(
    kind: str, place: str, what: str, *, mend: str = "", severity: Severity | None = None
) -> Finding:
    """Make a finding; what is not given is that of its kind (ours).

    Parameters
    ----------
    kind, place, what, mend, severity
        See `Finding`.
    """
    usual = KINDS[kind]
    return Finding(kind, severity or usual.severity, place, what, mend or usual.mend)
