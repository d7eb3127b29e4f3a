"""Which of the arguments is what: a scenario's name, or files of which kind."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from dmil.errors import InputError
from dmil.network.xml_file import XmlWalk
from dmil.scenarios.cityflow import find_cityflow_files
from dmil.scenarios.names import PREFIX, find_resco_configuration, kind_of, plain
from dmil.scenarios.sumo_configuration import ROOTS

EXPECTED = (
    "the name of a scenario, a .sumocfg, a .net.xml with its route files, or a folder or files of "
    "CityFlow"
)
_DRIVES = {"vehicle", "trip", "flow", "person", "personFlow", "route", "routeDistribution"}
_FURTHER = {
    *("vType", "vTypeDistribution", "tlLogic", "WAUT", "wautJunction", "include", "location"),
    *("busStop", "trainStop", "containerStop", "chargingStation", "parkingArea", "poly", "poi"),
    *("inductionLoop", "e1Detector", "laneAreaDetector", "e2Detector", "entryExitDetector"),
    *("e3Detector", "instantInductionLoop", "edgeData", "laneData", "timedEvent", "rerouter"),
    *("variableSpeedSign", "calibrator", "routeProbe", "taz", "tazs", "vTypeProbe"),
}
"""Elements that tell route files, and others that SUMO loads, where the root's name does not."""


@dataclass(frozen=True, slots=True)
class Given:
    """A scenario's name, or CityFlow's files (ours)."""

    name: str = ""
    network: Path | None = None
    flow: Path | None = None


@dataclass(frozen=True, slots=True)
class SumoFilesGiven:
    """SUMO's files, sorted by what they are (ours).

    Parameters
    ----------
    files
        As they were given.
    name
        Name of the scenario, empty if it was given as files.
    configuration, network, routes, additional
        What they are.
    """

    files: tuple[Path, ...]
    name: str = ""
    configuration: Path | None = None
    network: Path | None = None
    routes: tuple[Path, ...] = ()
    additional: tuple[Path, ...] = ()


def sort_arguments(arguments: Sequence[str]) -> Given | SumoFilesGiven:
    """Find out what the arguments of `dmil.doctor.read_case` are (ours).

    Raises
    ------
    InputError
        If they are not what can be examined.
    """
    if len(arguments) == 1:
        only = arguments[0]
        name = plain(only)
        if name.startswith(PREFIX) and not Path(only).exists():
            return _configured(find_resco_configuration(name), name)
        kind, rest = kind_of(only)
        if kind == "sumo" and rest:
            return _configured(Path(rest), only)
        if Path(only).is_dir():
            return Given(only, *find_cityflow_files(only))
        if not Path(only).is_file() and not _looks_like_a_file(only):
            return Given(only)
    paths = [Path(each) for each in arguments]
    if paths and all(path.suffix == ".json" or _begins_with(path, b"[", b"{") for path in paths):
        return _cityflow(paths)
    return _sumo(paths)


def _looks_like_a_file(text: str) -> bool:
    return not kind_of(text)[0] and any(mark in text for mark in "/\\.")


def _cityflow(paths: list[Path]) -> Given:
    lists = [path for path in paths if _begins_with(path, b"[")]
    networks = [path for path in paths if path not in lists]
    if len(networks) != 1 or len(lists) > 1:
        raise InputError(
            f"there are {len(networks)} road networks and {len(lists)} flows",
            where=", ".join(map(str, paths)),
            expected="one road network of CityFlow, and at most one flow",
        )
    return Given(network=networks[0], flow=lists[0] if lists else None)


def _begins_with(path: Path, *letters: bytes) -> bool:
    try:
        with path.open("rb") as file:
            return file.read(256).lstrip(b"\xef\xbb\xbf \t\r\n").startswith(letters)
    except OSError:
        return False  # the reader will say what is wrong


def _sumo(paths: list[Path]) -> SumoFilesGiven:
    found: dict[str, list[Path]] = {}
    for path in paths:
        root, _ = root_of(path)
        kind = "configuration" if root in ROOTS else root
        if kind not in ("configuration", "net", "routes", "additional"):
            kind = _kind_by_content(path, root)
        found.setdefault(kind, []).append(path)
    configurations, nets = found.get("configuration", []), found.get("net", [])
    if len(configurations) == len(paths) == 1:
        return _configured(paths[0], "")
    if len(nets) != 1 or configurations:
        raise InputError(
            f"there are {len(configurations)} configurations and {len(nets)} networks",
            where=", ".join(map(str, paths)) or "FILES",
            expected="one .sumocfg alone, or one .net.xml with its route files",
        )
    return SumoFilesGiven(
        files=tuple(paths),
        network=nets[0],
        routes=tuple(found.get("routes", ())),
        additional=tuple(found.get("additional", ())),
    )


def _kind_by_content(path: Path, root: str) -> str:
    """Say what a file of SUMO is whose root element has a name of the user's own."""
    met: set[str] = set()

    def start(name: str, attributes: dict[str, str]) -> None:
        met.add(name)

    XmlWalk(path, start, met.add).run()
    if met & _DRIVES:
        return "routes"
    if met & _FURTHER:
        return "additional"
    raise InputError(
        f"its root element is <{root}>, and nothing in it is SUMO's",
        where=str(path),
        expected=f"{EXPECTED}",
        mend="check that this is the right file",
    )


def _configured(path: Path, name: str) -> SumoFilesGiven:
    return SumoFilesGiven(files=(path,), name=name, configuration=path)


class _Met(Exception):  # noqa: N818  nothing is wrong: it ends the walk at the first element
    def __init__(self, name: str, attributes: dict[str, str]) -> None:
        super().__init__(name)
        self.name, self.attributes = name, attributes


def root_of(path: Path) -> tuple[str, Mapping[str, str]]:
    """Return name and attributes of an XML file's root element, which says what it is (ours).

    Raises
    ------
    InputError
        If it is missing, or no XML that may be read.
    """

    def start(name: str, attributes: dict[str, str]) -> None:
        raise _Met(name, attributes)

    def end(name: str) -> None:
        pass

    try:
        XmlWalk(path, start, end).run()
    except _Met as met:
        return met.name, met.attributes
    return "", {}
