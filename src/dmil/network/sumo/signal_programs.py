"""Signal programs as SUMO collects them: the network's, those of additional files, timetables.

Of several programs of one signal SUMO shows the one that was loaded last, and a schedule (WAUT)
chooses by the time of day (SUMO docs: Traffic Lights).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from xml.etree.ElementTree import Element, tostring

from dmil.errors import NetworkError
from dmil.network.sumo.records import Logic, StageRecord
from dmil.network.xml_file import XmlPlace, iter_elements

OFF = "off"
"""Program that switches a signal off, and its type."""
RAIL_KINDS = ("railsignal", "railcrossing", "rail_signal", "rail_crossing")
"""Types of signals that SUMO works out from where trains are."""
_UNNAMED = "<unknown>"
_READ = ("tlLogic", "WAUT", "wautJunction")


@dataclass(slots=True)
class _Timetable:
    begin: str
    switches: list[tuple[float, str]]

    def at(self, begin_s: float) -> tuple[str, tuple[tuple[float, str], ...]]:
        """Return the program at a time and what follows, as SUMO does: the switch after it says."""
        following = [k for k, (when_s, _) in enumerate(self.switches) if when_s > begin_s]
        first = min(following, key=lambda k: self.switches[k][0], default=len(self.switches))
        return self.switches[first - 1][1] if first else self.begin, tuple(self.switches[first:])


@dataclass(slots=True)
class SignalPrograms:
    """The programs of all signals, in the order in which SUMO would load them (ours).

    ``begin_s`` is SUMO's time at which a run begins.
    """

    begin_s: float = 0.0
    _programs: dict[str, dict[str, Logic]] = field(default_factory=dict)
    _chosen: dict[str, str] = field(default_factory=dict)
    _timetables: dict[str, _Timetable] = field(default_factory=dict)
    _switches: dict[str, tuple[tuple[float, str], ...]] = field(default_factory=dict)
    _added: list[str] = field(default_factory=list)

    @property
    def added_xml(self) -> str:
        """What was read from additional files, as XML elements without a root element."""
        return "".join(f"{text}\n" for text in self._added)

    def read(self, paths: Sequence[str | Path]) -> None:
        """Take up what additional files define; whatever else they hold is passed over.

        Raises
        ------
        NetworkError
            If a file is missing, cut off, unsafe or no XML, or says what SUMO would refuse.
        """
        for path in paths:
            for place, element in iter_elements(
                path, _READ, root=("additional", "routes"), error=NetworkError
            ):
                if element.tag == "tlLogic" and element.get("id") not in self._programs:
                    if element.get("type", "").lower() in RAIL_KINDS:
                        continue
                    raise _error(
                        place, element, "the network has no signal of this id", "one of its signals"
                    )
                self.define(element, place)
                self._added.append(tostring(element, encoding="unicode").strip())

    def define(self, element: Element, place: XmlPlace | str) -> None:
        """Take up a ``<tlLogic>``, ``<WAUT>`` or ``<wautJunction>``.

        Raises
        ------
        NetworkError
            If something in it is missing, cannot be understood, or would be refused by SUMO.
        """
        try:
            if element.tag == "tlLogic":
                self._logic(element, place)
            elif element.tag == "WAUT":
                self._timetable(element)
                for child in element.findall("wautJunction"):
                    self._follow(child, place)
            else:
                self._follow(element, place)
        except KeyError as cause:
            raise _error(place, element, f"its attribute '{cause.args[0]}' is missing") from None
        except ValueError as cause:
            raise _error(place, element, f"it cannot be understood ({cause})") from None

    def _logic(self, element: Element, place: XmlPlace | str) -> None:
        name, program = element.attrib["id"], element.get("programID", _UNNAMED)
        offset = element.get("offset", "0")
        offset_s = self.begin_s if offset == "begin" else float(offset)
        stages = tuple(_stage(each) for each in element.iter("phase"))
        if not all(map(math.isfinite, (offset_s, *(s.duration_s for s in stages)))) or any(
            stage.duration_s < 0 for stage in stages
        ):
            raise _error(
                place, element, "an offset or a duration is no time", "seconds, durations 0 or more"
            )
        here = self._programs.setdefault(name, {})
        known = here.get(program)
        kind = OFF if program == OFF else element.get("type", "static")
        if known and stages:
            raise _error(
                place, element, f"there is another program '{program}' of it", "another programID"
            )
        if known:  # as in SUMO it moves the program that is there, and no other is shown
            here[program] = replace(known, offset_s=offset_s)
            return
        if not stages and kind != OFF and kind.lower() not in RAIL_KINDS:
            raise _error(place, element, "its program has no stages", "<phase> elements")
        here[program] = Logic(name, kind, offset_s, stages, ())
        self._chosen[name] = program

    def _timetable(self, element: Element) -> None:
        reference_s = _time_s(element.get("refTime", "0"))
        period_s = _time_s(element.get("period", "0"))
        switches = []
        for child in element.iter("wautSwitch"):
            when_s = reference_s + _time_s(child.attrib["time"])
            switches.append((when_s % period_s if period_s > 0 else when_s, child.attrib["to"]))
        begin = element.get("startProg", "")
        self._timetables[element.attrib["id"]] = _Timetable(begin, switches)

    def _follow(self, element: Element, place: XmlPlace | str) -> None:
        name, signal = element.attrib["wautID"], element.attrib["junctionID"]
        timetable = self._timetables.get(name)
        if timetable is None or signal not in self._programs:
            what = f"signal '{signal}'" if timetable else f"WAUT '{name}'"
            raise _error(place, element, f"there is no {what}", "one that is defined before it")
        program, self._switches[signal] = timetable.at(self.begin_s)
        for wanted in (program, *(to for _, to in self._switches[signal])):
            if wanted not in self._programs[signal] and wanted != OFF:
                raise _error(
                    place,
                    element,
                    f"signal '{signal}' has no program '{wanted}'",
                    f"one of {', '.join(self._programs[signal])}",
                )
        self._chosen[signal] = program

    def used(self, longest_letter: dict[str, int], path: str) -> tuple[Logic, ...]:
        """Return the program of every signal that is in charge when a run begins.

        Signals of trains are left out. One that is switched off has the stages of its last program.
        ``longest_letter`` is by signal the greatest index into its states that a connection names.

        Raises
        ------
        NetworkError
            If a state string is shorter than its connections need.
        """
        found = []
        for name, programs in self._programs.items():
            real = {
                key: each
                for key, each in programs.items()
                if each.stages and each.kind.lower() not in RAIL_KINDS
            }
            if not real:
                continue
            chosen = self._chosen[name]
            logic = replace(
                real.get(chosen) or replace(list(real.values())[-1], kind=OFF),
                programs=(*(key for key in programs if key != chosen), chosen),
                switches=self._switches.get(name, ()),
            )
            _check_letters(logic, longest_letter.get(name, -1), path)
            found.append(logic)
        return tuple(found)


def _stage(element: Element) -> StageRecord:
    given = element.attrib
    if "duration" not in given and "minDur" in given:
        duration_s = (float(given["minDur"]) + float(given["maxDur"])) / 2
    else:
        duration_s = float(given["duration"])
    after = tuple(int(each) for each in given.get("next", "").split())
    limits = (float(given[name]) if name in given else None for name in ("minDur", "maxDur"))
    return StageRecord(duration_s, given["state"], after, *limits)


def _time_s(text: str) -> float:
    parts = [float(part) for part in text.split(":")]
    weights = (86400, 3600, 60, 1)[-len(parts) :]
    return sum(part * weight for part, weight in zip(parts, weights, strict=True))


def _check_letters(logic: Logic, longest: int, path: str) -> None:
    for index, stage in enumerate(logic.stages):
        if len(stage.state) <= longest:
            raise NetworkError(
                f"stage {index} has {len(stage.state)} letters ({stage.state}), but its "
                f"connections name letter {longest}",
                where=f"{path}: tlLogic {logic.id}",
                expected=f"at least {longest + 1} letters, one per connection",
                mend="complete the state, or rebuild the network with netconvert",
            )


def _error(
    place: XmlPlace | str, element: Element, problem: str, expected: str | None = None
) -> NetworkError:
    name = element.get("id") or element.get("wautID", "")
    return NetworkError(
        problem,
        where=f"{place}: {element.tag} '{name}'",
        expected=expected or "programs as netconvert or netedit write them",
        mend="correct this; SUMO also rejects it",
    )
