"""Recorded cities in a folder of data, as several studies name them: ``cityflow:jinan_3x4``."""

from __future__ import annotations

from pathlib import Path

from dmil.errors import InputError
from dmil.scenarios.cityflow import holds_list

CITY = "cityflow:"
"""What the name of a city's scenario begins with; its folder's name follows."""


def city_folder(data: Path | None) -> Path:
    """Return the folder of the cities' folders: the one given, or ``cityflow`` in it (ours).

    Raises
    ------
    InputError
        None was given, or it is no folder.
    """
    expected = "a folder with one folder per city, in CityFlow's format"
    if data is None:
        mend = "add --data DIR, or set DMIL_DATA"
        raise InputError("no data folder was given", where="cells", expected=expected, mend=mend)
    inner = data / "cityflow"
    folder = inner if inner.is_dir() else data
    if not folder.is_dir():
        mend = "check --data or DMIL_DATA"
        raise InputError("there is no such folder", where=str(data), expected=expected, mend=mend)
    return folder


def city_cells(data: Path) -> tuple[str, ...]:
    """Return the names of the cells in a folder of data: every city with its first flow (ours).

    The first is that with whose name those of all others begin, or the first by name.

    Raises
    ------
    InputError
        There is no such folder, or no city in it.
    """
    folder = city_folder(data)
    found = []
    for city in sorted(path.parent for path in folder.glob("*/roadnet*.json")):
        flows = sorted(path.stem for path in city.glob("*.json") if holds_list(path))
        if flows:
            alone = all(other.startswith(flows[0]) for other in flows)
            found.append(f"{CITY}{city.name}" + ("" if alone else f"#{flows[0]}.json"))
    if not found:
        raise InputError(
            "it holds no city",
            where=str(folder),
            expected="one folder per city with roadnet*.json and flow files",
        )
    return tuple(found)
