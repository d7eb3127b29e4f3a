"""What a scenario is: network, demand, signal timing, queue dynamics, horizon, SUMO's files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from pydantic import Field

from dmil.demand import Demand
from dmil.demand.sumo.beside import NOTHING, Beside
from dmil.errors import InputError
from dmil.network import RoadNetwork
from dmil.network.permissions import Classes
from dmil.network.sumo import SumoSignals
from dmil.scenarios.timing import Settings, SignalTiming

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


@dataclass(frozen=True)
class CityflowFiles:
    """What CityFlow needs of a scenario beside its vehicles (ours).

    Parameters
    ----------
    roadnet
        The road network.
    kinds
        Lengths, speeds and accelerations of vehicles, as in a flow file; ``Vehicles.kind`` are
        indices into it.
    """

    roadnet: Path
    kinds: tuple[dict[str, float], ...]


LONGEST_RUN_S = 10**8
"""Longest run, three years: steps are counted in 32 bits."""
FROM_FILES: dict[str, Any] = {"saturation_flow_veh_per_s": 0.5, "storage": True}
"""Settings of `QueueDynamics` that scenarios from files have."""
HIGHEST_LOAD = 1e6
"""Highest factor on a demand: what is above would fill any memory with vehicles."""


class QueueDynamics(Settings):
    """How queues discharge and fill."""

    saturation_flow_veh_per_s: float = Field(
        default=1.0,
        gt=0,
        allow_inf_nan=False,
        description="Saturation flow in vehicles per second and lane (the paper's v*, which it "
        "does not state).",
    )
    storage: bool = Field(
        default=False,
        description="Whether links have finite storage, so that queues spill back (paper: no).",
    )
    vehicle_space_m: float = Field(
        default=7.5,
        gt=0,
        allow_inf_nan=False,
        description="Lane metres per queued vehicle, gap included; used with storage only.",
    )
    gap_wait_s: int = Field(
        default=20,
        ge=0,
        description="Maximum wait in seconds of a yielding vehicle at the head of a lane while "
        "others with green and a queue have priority; used where a network defines who yields "
        "(paper: no).",
    )
    start_wave_veh_per_s: float = Field(
        default=0.0,
        ge=0,
        allow_inf_nan=False,
        description="Vehicles per second and lane that start to move in a queue at green; moving "
        "vehicles no longer count in the queue that controllers see. 0: a vehicle counts "
        "until it has left (paper).",
    )


def horizon_of(last_departure_s: int) -> int:
    """Return the length of a run with recorded vehicles: until the last one, in whole 600 s."""
    return 600 * (max(0, last_departure_s) // 600 + 1)


@dataclass(frozen=True)
class Scenario:
    """Everything that a simulator needs but the seed and the controller (ours).

    Parameters
    ----------
    name
        Name as given to `dmil.scenarios.scenario`.
    network, demand, timing, dynamics
        Its parts.
    horizon_s
        Length of a run in seconds.
    sumo
        SUMO's files of the scenario, if it comes from such.
    link_time_s
        (links,) seconds that an undisturbed vehicle needs for each link, where they were measured;
        else length and speed tell.
    link_free_s
        (links,) seconds of these that are free flow, beyond which time counts as lost, where they
        were measured; else length and speed tell.
    ignore_junction_blocker_s
        SUMO only: a vehicle that has stood on a junction for so many seconds blocks nobody any
        more (``--ignore-junction-blocker``). None: it blocks until it moves, or as a configuration
        says.
    cityflow
        CityFlow's files of the scenario, if it comes from such.

    Raises
    ------
    InputError
        If the horizon is not a positive whole number, or no decision fits into it.
    """

    name: str
    network: RoadNetwork
    demand: Demand
    timing: SignalTiming
    dynamics: QueueDynamics
    horizon_s: int
    sumo: SumoFiles | None = None
    link_time_s: tuple[float, ...] | None = None
    link_free_s: tuple[float, ...] | None = None
    ignore_junction_blocker_s: int | None = None
    cityflow: CityflowFiles | None = None

    def __post_init__(self) -> None:
        whole = isinstance(self.horizon_s, int) and not isinstance(self.horizon_s, bool)
        if not whole or self.horizon_s < self.timing.decision_interval_s:
            raise InputError(
                f"the horizon is {self.horizon_s!r} s",
                where=f"scenario {self.name}",
                expected="a whole number of seconds, at least one decision interval "
                f"({self.timing.decision_interval_s} s)",
            )
