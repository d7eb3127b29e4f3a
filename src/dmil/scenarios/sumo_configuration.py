"""Reader of SUMO's configurations: which files belong together, when a run begins and ends."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from urllib.parse import unquote

from dmil.demand.sumo.entry import seconds_of
from dmil.errors import InputError
from dmil.network.xml_file import XmlWalk
from dmil.scenarios.sumo_options import OPTIONS

ROOTS = ("configuration", "sumoConfiguration")
SCENERY = (".poly.xml", ".poi.xml", ".poly.xml.gz", ".poi.xml.gz")
"""Endings of files that are only drawn, by the habit of SUMO's tools (osmWebWizard); who hands a
network on often leaves them out."""
_VARIABLE = re.compile(r"\$\{(.+?)\}")


@dataclass(frozen=True)
class SumoConfiguration:
    """Which files belong together, and when a run begins and ends (ours).

    Parameters
    ----------
    net_file
        The network.
    route_files
        Vehicles, trips and flows; without one a program of its own may send them, as in SUMO.
    additional_files
        Files with further vehicle types and routes, vehicles, and programs of signals; whatever
        else they hold is not used.
    begin_s, end_s
        SUMO's times; without an end the last departure decides.
    scale
        Factor on the demand.
    unused
        Options of the file that could change how vehicles drive and are not taken over, as
        ``name=value``; a length of steps too of which 1 s is no multiple, since SUMO is asked
        every second.
    for_sumo
        Options that SUMO is told as they stand, as (name, value).
    """

    net_file: Path
    route_files: tuple[Path, ...]
    additional_files: tuple[Path, ...] = ()
    begin_s: int = 0
    end_s: float | None = None
    scale: float = 1.0
    unused: tuple[str, ...] = ()
    for_sumo: tuple[tuple[str, str], ...] = ()


def read_sumo_configuration(path: str | Path) -> SumoConfiguration:
    """Read a SUMO configuration (``.sumocfg``); its paths are relative to it (ours).

    As in SUMO the names of the root element and of the sections do not matter, options may be
    given by any of their names, and ``${NAME}`` stands for a variable of the environment, or for
    nothing where there is none.

    Parameters
    ----------
    path
        The file.

    Raises
    ------
    InputError
        If it is missing, cut off, not XML or of another kind, names no network, an option is
        unknown, given twice or cannot be followed, or a time is not valid.
    """
    options = _Options(str(path))
    walk = XmlWalk(path, options.start, options.end, text=options.text, root=ROOTS)
    options.walk = walk
    walk.run()
    folder = Path(path).parent
    nets = options.paths("net-file", folder)
    if not nets:
        raise _unnamed("net-file", str(path))
    begin_s = options.seconds("begin") or 0.0
    if begin_s != int(begin_s):
        raise options.error("begin", "whole seconds, since a run has steps of 1 s")
    end_s = options.seconds("end")
    step_s = options.number("step-length", 1.0)
    whole = abs(1 / step_s - round(1 / step_s)) < 1e-9
    if step_s != 1:
        (options.for_sumo if whole else options.unused).append(("step-length", f"{step_s:g}"))
    return SumoConfiguration(
        net_file=nets[0],
        route_files=options.paths("route-files", folder),
        additional_files=tuple(
            file
            for file in options.paths("additional-files", folder)
            if file.exists() or not file.name.endswith(SCENERY)
        ),
        begin_s=int(begin_s),
        end_s=end_s,
        scale=options.number("scale", 1.0),
        unused=tuple(f"{name}={value}" for name, value in options.unused),
        for_sumo=tuple(options.for_sumo),
    )


def driving(configuration: SumoConfiguration, where: str) -> SumoConfiguration:
    """Return a configuration, read from the file ``where``, that has files with vehicles (ours).

    Raises
    ------
    InputError
        If it names neither route files nor additional ones.
    """
    if not configuration.route_files and not configuration.additional_files:
        raise _unnamed("route-files", where)
    return configuration


def _unnamed(name: str, where: str) -> InputError:
    return InputError(
        f"it names no {name}",
        where=where,
        expected=f'<{name} value="…"/>',
        mend="add it, or give the files themselves (--net and --routes)",
    )


@dataclass(slots=True)
class _Options:
    """The options of a configuration as they are met."""

    path: str
    walk: XmlWalk | None = None
    unused: list[tuple[str, str]] = field(default_factory=list)
    for_sumo: list[tuple[str, str]] = field(default_factory=list)
    _given: dict[str, tuple[str, str]] = field(default_factory=dict)
    _place: str = ""
    _text: str = ""
    _missing: bool = False

    def start(self, name: str, attributes: Mapping[str, str]) -> None:
        self._text = ""
        self._place = str(self.walk.place if self.walk else self.path)
        value = attributes.get("value", attributes.get("v"))
        self._missing = value is None
        if value is not None:
            self._take(name, value)

    def text(self, piece: str) -> None:
        self._text += piece

    def end(self, name: str) -> None:
        """Take the text within an element for its value, as SUMO does, if it has no other."""
        if self._missing and self._text.strip():
            self._take(name, self._text.strip())
        self._missing = False  # without any it counts as not given: SUMO complains and goes on

    def _take(self, name: str, value: str) -> None:
        value = _VARIABLE.sub(_variable, value)
        if not value:
            return  # as in SUMO
        option, wrong = OPTIONS.get(name), partial(InputError, where=self._place)
        if option is None:
            raise wrong(
                f"SUMO has no option '{name}'",
                expected="options of SUMO 1.28, as sumo --save-template FILE lists them",
                mend="remove or correct it",
            )
        if option.name in self._given:
            raise wrong(
                f"the option {option.name} is given twice",
                expected="every option once, as in SUMO",
                mend="remove one of them",
            )
        self._given[option.name] = value, self._place
        if value == option.default:
            return
        if option.treatment == "refused":
            raise wrong(
                f"the option {option.name} ({value}) cannot be followed: {option.reason}",
                mend="remove it",
            )
        if option.treatment == "noted":
            self.unused.append((option.name, value))
        elif option.treatment == "sumo":
            self.for_sumo.append((option.name, value))

    def error(self, name: str, expected: str) -> InputError:
        value, place = self._given[name]
        return InputError(f"{name} is '{value}'", where=place, expected=expected)

    def paths(self, name: str, folder: Path) -> tuple[Path, ...]:
        names = self._given.get(name, ("", ""))[0].split(",")
        return tuple(folder / unquote(each.strip()) for each in names if each.strip())

    def seconds(self, name: str) -> float | None:
        """Return a time, None if it is missing or negative, which SUMO takes for missing."""
        if name not in self._given:
            return None
        value = seconds_of(self._given[name][0])
        if value is None:
            raise self.error(name, "seconds, or hours:minutes:seconds")
        return value if value >= 0 else None

    def number(self, name: str, default: float) -> float:
        if name not in self._given:
            return default
        try:
            value = float(self._given[name][0])
        except ValueError:
            value = math.nan
        if not (math.isfinite(value) and value > 0):
            raise self.error(name, "a number above 0")
        return value


def _variable(found: re.Match[str]) -> str:
    """Return what stands for a variable: SUMO knows three beside those of the environment."""
    name = found[1]
    if name in ("LOCALTIME", "UTC"):
        zone = UTC if name == "UTC" else None
        return datetime.now(zone).strftime("%Y-%m-%d-%H-%M-%S")
    return str(os.getpid()) if name == "PID" else os.environ.get(name, "")
