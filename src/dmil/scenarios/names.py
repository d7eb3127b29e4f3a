"""What the name of a scenario begins with, and what is a path."""

from __future__ import annotations

from pathlib import PurePath

KINDS = ("grid", "cityflow", "sumo")


def kind_of(name: str) -> tuple[str, str]:
    r"""Split a scenario's name into its kind and the rest (ours).

    Capitals in the kind do not matter. What stands before the colon is no kind where it is the
    letter of a drive, as in ``C:\roads\city.sumocfg``.

    Parameters
    ----------
    name
        Such as ``grid:5x5``.

    Returns
    -------
    tuple of str
        ``grid``, ``cityflow``, ``sumo``, or nothing; what follows its colon, or the whole name.
    """
    kind, colon, rest = name.partition(":")
    known = bool(colon) and kind.lower() in KINDS
    return (kind.lower(), rest) if known else ("", name)


def plain(name: str) -> str:
    """Return a name as it is looked up: paths as they stand, all else in small letters (ours)."""
    kind, rest = kind_of(name)
    if kind == "grid" or name.lower().startswith("resco/"):
        return name.lower()
    if kind:
        return f"{kind}:{rest}"
    return f"sumo:{name}" if name.lower().endswith(".sumocfg") else name


def shown(name: str) -> str:
    """Return a name as headings show it: of a path only its last part (ours)."""
    kind, rest = kind_of(name)
    return PurePath(rest).name if kind in ("cityflow", "sumo") and rest else name
