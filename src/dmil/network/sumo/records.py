"""What the reader gives: the network, how its signals are named in SUMO, what is suspicious."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from dmil.network.model import RoadNetwork
from dmil.network.sumo.net_records import NetFile

RemarkKind = Literal[
    "no-vehicles",
    "two-controllers",
    "several-programs",
    "no-action",
    "single-action",
    "never-served",
    "empty-stage",
    "pedestrian-stage",
    "missing-yellow",
    "conflicting-greens",
    "stage-order",
    "no-right-of-way",
    "own-control",
    "signal-of-sumo",
    "program-switches",
]


@dataclass(frozen=True, slots=True)
class Remark:
    """Something that can be read, but that a user should know of (ours).

    Parameters
    ----------
    kind
        What it is about, one word for all of its sort:

        - ``no-vehicles``: a controller of no vehicle; it is left out.
        - ``two-controllers``: a junction under two controllers; what the lesser one controls always
        open.
        - ``several-programs``: the last one is used, as SUMO does.
        - ``no-action``: no stage of the program gives green; the phases are derived instead.
        - ``single-action``: there is nothing to choose.
        - ``never-served``: a movement that no action serves; phases are added for it.
        - ``empty-stage``: a long stage in which nothing goes.
        - ``pedestrian-stage``: a stage in which only those go who are no vehicles; no action
          shows it.
        - ``missing-yellow``: a green turns red at once.
        - ``conflicting-greens``: two lanes that cross or merge have the right of way at once.
        - ``stage-order``: stages that do not follow each other in the file's order.
        - ``own-control``: a control that only SUMO can run, such as NEMA rings.
        - ``signal-of-sumo``: a signal without a program, such as a rail crossing; SUMO runs it.
        - ``program-switches``: a timetable switches between programs during the day.
        - ``no-right-of-way``: the junction's matrix of right of way is missing; roads are taken to
          conflict with each other.
    where
        File and place in it.
    text
        What was found.
    mend
        What to do about it.
    """

    kind: RemarkKind
    where: str
    text: str
    mend: str


@dataclass(frozen=True, slots=True)
class SumoSignals:
    """How the phases of one intersection are shown in SUMO (ours).

    Parameters
    ----------
    id
        Id of the ``tlLogic``; the intersection's id too.
    states
        SUMO's state string of every phase, with the letters of the file.
    links
        For every movement its indices into these strings, of the lanes that vehicles use; none if
        no signal controls it.
    crossings
        For every crossing of pedestrians its index into these strings.
    """

    id: str
    states: tuple[str, ...]
    links: tuple[tuple[int, ...], ...]
    crossings: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class SumoNetwork:
    """A road network together with what is needed to drive it in SUMO (ours).

    Parameters
    ----------
    path
        The file.
    network
        What was read.
    signals
        One per intersection, in their order.
    remarks
        What is suspicious about the file, in the order of its signals.
    file
        What it was made from.
    derived
        Whether the phases are derived from conflicts.
    """

    path: Path
    network: RoadNetwork
    signals: tuple[SumoSignals, ...]
    remarks: tuple[Remark, ...]
    file: NetFile = field(repr=False)
    derived: bool = False

    @property
    def added_programs_xml(self) -> str:
        """Programs and timetables of additional files, as XML elements without a root element."""
        return self.file.added_programs_xml
