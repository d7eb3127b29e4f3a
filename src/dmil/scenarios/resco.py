"""The scenarios of the RESCO benchmark, from the files that the package sumo-rl brings."""

from __future__ import annotations

import importlib.util
from pathlib import Path

from dmil.errors import InputError, MissingExtraError, unknown_name

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

    Parameters
    ----------
    name
        Such as ``resco/cologne1``.

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
