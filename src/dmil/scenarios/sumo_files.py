"""What SUMO is told about a scenario that comes from its files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from dmil.demand.sumo.beside import NOTHING, Beside
from dmil.network.permissions import Classes
from dmil.network.sumo import SumoSignals

Routing = Literal["sumo", "mesoscopic", "free-flow"]
"""Where the ways of trips are from: SUMO's choice in the traffic, that in its mesoscopic model of
the traffic, or the shortest at free flow."""


@dataclass(frozen=True)
class SumoFiles:
    """What SUMO needs of a scenario beside its network and vehicles (ours).

    Parameters
    ----------
    net_file
        The network.
    signals
        How SUMO shows the phases, one per intersection.
    kinds
        Attributes of SUMO's vehicles; ``Vehicles.kind`` are indices into it.
    classes
        The vehicle classes of every such kind, which decide where vehicles may drive.
    beside
        What SUMO runs beside the vehicles of the demand, and their types.
    begin_s
        SUMO's second that is second 0 of a run.
    routing
        Where the ways of trips are from; None where all vehicles have a route.
    programs_xml
        Signal programs and timetables beside the network's, as XML elements without a root element.
    persons_xml
        The persons who walk, as XML elements in the order of departure, without a root element.
    options
        Further options of ``sumo``, as (name, value).
    """

    net_file: Path
    signals: tuple[SumoSignals, ...]
    kinds: tuple[dict[str, str], ...] = ({},)
    classes: tuple[Classes, ...] = (Classes(),)
    beside: Beside = NOTHING
    begin_s: int = 0
    routing: Routing | None = None
    programs_xml: str = ""
    persons_xml: str = ""
    options: tuple[tuple[str, str], ...] = ()
