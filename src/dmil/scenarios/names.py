"""What the name of a scenario begins with, what is a path, and where RESCO's scenarios are."""

from __future__ import annotations

import importlib.util
from pathlib import Path, PurePath

from dmil.errors import InputError, MissingExtraError, unknown_name

KINDS = ("grid", "cityflow", "sumo")


def kind_of(name: str) -> tuple[str, str]:
    r"""Split a scenario's name, such as ``grid:5x5``, into its kind and what follows it (ours).

    Capitals in the kind do not matter. Of a name without one of the `KINDS` the kind is empty: what
    stands before the colon may be the letter of a drive, as in ``C:\roads\city.sumocfg``.
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


PREFIX = "resco/"
RESCO = {
    f"{PREFIX}cologne1": "RESCO: an intersection of Cologne",
    f"{PREFIX}cologne3": "RESCO: a corridor of 3 intersections in Cologne",
    f"{PREFIX}cologne8": "RESCO: a region of 8 intersections in Cologne",
    f"{PREFIX}ingolstadt1": "RESCO: an intersection of Ingolstadt",
    f"{PREFIX}ingolstadt7": "RESCO: a corridor of 7 intersections in Ingolstadt",
    f"{PREFIX}ingolstadt21": "RESCO: a region of 21 intersections in Ingolstadt",
    f"{PREFIX}grid4x4": "RESCO: a made-up grid of 16 intersections",
    f"{PREFIX}arterial4x4": "RESCO: a made-up grid of 16 intersections, with arterial roads",
}
"""Name to what it is."""


def find_resco_configuration(name: str) -> Path:
    """Find the configuration of a scenario of RESCO in the installed package sumo-rl (ours).

    The package is not imported: that would need an environment variable.

    Raises
    ------
    UnknownNameError
        If there is no such scenario.
    MissingExtraError
        If the package is not installed.
    InputError
        If it does not have the scenario's files.
    """
    if name not in RESCO:
        raise unknown_name("scenario", name, RESCO)
    package = importlib.util.find_spec("sumo_rl")
    if package is None or not package.submodule_search_locations:
        raise MissingExtraError("sumo")
    short = name.removeprefix(PREFIX)
    path = Path(package.submodule_search_locations[0], "nets", "RESCO", short, f"{short}.sumocfg")
    if not path.is_file():
        raise InputError(
            f"the installed package sumo-rl does not have the scenario '{short}'",
            where=str(path),
            expected="sumo-rl 1.4.5 or later",
            mend="install it again: pip install --force-reinstall 'dmil[sumo]'",
        )
    return path
