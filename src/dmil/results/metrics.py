"""The catalogue of metrics: all that is said of one, and which tables show it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Literal


@dataclass(frozen=True, slots=True)
class Metric:
    """A number that a run ends with; it is a property of `dmil.simulation.Measures` of its name.

    Parameters
    ----------
    label, unit
        What tables call it; the unit is "" where the label says it.
    meaning
        One sentence.
    digits, fine_digits
        Digits after the point; the second where one controller is shown alone.
    better
        Whether less or more of it is better, None if neither is.
    sumo_only
        Whether only SUMO knows it; elsewhere it is null.
    cityflow_only
        The same of CityFlow.
    optional
        Whether tables leave it out where it is zero throughout, as memory where there is none.
    whole
        Whether it is a whole number.
    memory
        Whether it is one of `dmil.controllers.MemoryUse` instead.
    stored
        Whether it is a column of the results.
    factor
        What the number is multiplied with where it is shown.
    short
        Label and unit where controllers stand side by side, if others.
    head
        Head of its column in pages, if not label and unit.
    """

    label: str
    unit: str
    meaning: str
    digits: int = 1
    fine_digits: int | None = None
    better: Literal["less", "more"] | None = None
    sumo_only: bool = False
    cityflow_only: bool = False
    optional: bool = False
    whole: bool = False
    memory: bool = False
    stored: bool = True
    factor: float = 1.0
    short: tuple[str, str] = ("", "")
    head: str = ""

    @property
    def short_label(self) -> tuple[str, str]:
        """Label and unit where controllers stand side by side."""
        return self.short if self.short[0] else (self.label, self.unit)

    @property
    def column_head(self) -> str:
        """Head of its column in pages."""
        return self.head or f"{self.label}, {self.unit}"


_count = partial(Metric, digits=0, whole=True)
_memory = partial(_count, optional=True, memory=True)
_at_intersections = partial(Metric, better="less", cityflow_only=True)
_emission = partial(Metric, better="less", sumo_only=True, optional=True, factor=1e-3)

METRICS: dict[str, Metric] = {
    "spawned_veh": _count("vehicles departed", "veh", "Vehicles whose departure time has come."),
    "arrived_veh": _count(
        "V_c, vehicles arrived",
        "veh",
        "V_c: vehicles at their destination at the end of the run.",
        better="more",
    ),
    "wait_veh_s": _count(
        "waiting of all vehicles",
        "veh s",
        "Vehicles that wait, in queues or outside for room, summed over all seconds.",
        better="less",
    ),
    "wait_per_spawned_s": Metric(
        "W, wait per vehicle",
        "s",
        "The paper's W: time halting in queues or waiting outside for room, per spawned vehicle.",
        fine_digits=2,
        better="less",
        short=("W, waiting", "s"),
        head="waiting, s",
    ),
    "w_over_vc": Metric(
        "W/V_c",
        "s/veh",
        "W divided by V_c at the end of the run: the paper's headline number.",
        digits=4,
        better="less",
    ),
    "wait_per_visit_s": Metric(
        "wait per intersection visit",
        "s",
        "Waiting of all vehicles per visit of an intersection.",
        digits=2,
        better="less",
    ),
    "wait_per_arrived_s": Metric(
        "wait of arrived vehicles",
        "s",
        "Mean waiting time of the vehicles that arrived.",
        digits=2,
        better="less",
    ),
    "mean_queue_veh": Metric(
        "mean queue in the network",
        "veh",
        "Vehicles waiting, averaged over the run.",
        fine_digits=2,
        better="less",
        short=("mean queue", "veh"),
        head="mean queue, veh",
    ),
    "travel_time_s": Metric(
        "travel time",
        "s",
        "CityFlow's average travel time: scheduled departure to arrival per spawned vehicle; those "
        "that have not arrived count up to the end of the run.",
        better="less",
    ),
    "delay_s": Metric(
        "delay",
        "s",
        "RESCO's average delay: (time loss + departure delay) per spawned vehicle, with those that "
        "have not arrived or never departed counted up to the end of the run.",
        better="less",
    ),
    "last_minus_first_s": _at_intersections(
        "last minus first",
        "s",
        "LLMLight's travel time: of every intersection and vehicle the last leaving of its "
        "entering lanes minus the first entering, summed over intersections, per vehicle that was "
        "ever there; one that has not left counts up to the horizon.",
    ),
    "entering_lanes_s": _at_intersections(
        "time on entering lanes",
        "s",
        "Time on entering lanes of intersections, per vehicle that was ever there.",
    ),
    "throughput_veh_per_h": Metric(
        "throughput",
        "veh/h",
        "Vehicles that arrived, per hour.",
        digits=0,
        better="more",
        head="arrived, veh/h",
    ),
    "stops_per_spawned": Metric(
        "stops per vehicle",
        "",
        "Stops of vehicles inside the network, per spawned vehicle.",
        digits=2,
        better="less",
        short=("stops", "per vehicle"),
        head="stops per vehicle",
    ),
    "co2_g": _emission(
        "CO2",
        "g",
        "Carbon dioxide by SUMO's emission model, all vehicles.",
        short=("CO2", "kg, all vehicles"),
        head="CO2, kg",
    ),
    "fuel_g": _emission(
        "fuel",
        "g",
        "Fuel by SUMO's emission model, all vehicles.",
        short=("fuel", "kg, all vehicles"),
        head="fuel, kg",
    ),
    "person_delay_s": Metric(
        "delay of persons",
        "s",
        "Time that pedestrians stand still, mostly at crossings, per departed person; those still "
        "walking count up to the end of the run.",
        better="less",
        sumo_only=True,
        optional=True,
        short=("persons' delay", "s"),
    ),
    "overruled": _count(
        "phase requests overruled",
        "",
        "Phase requests that the rules of signal timing did not grant.",
        optional=True,
        short=("overruled", "phase requests"),
        head="requests overruled",
    ),
    "entries_per_agent": _memory(
        "memory entries per intersection",
        "",
        "Stored states at the end of the run, mean over agents.",
        digits=1,
        whole=False,
        short=("memory entries", "per intersection"),
    ),
    "entries_total": _memory(
        "memory entries", "", "Stored states at the end of the run, a shared table counted once."
    ),
    "bytes_total": _memory("memory of all intersections", "bytes", "True size of all memories."),
    "messages": _memory(
        "messages",
        "",
        "Messages between agents and the central unit in the run, both ways, lost ones too.",
    ),
    "exchanged_bytes": _memory("exchanged", "bytes", "Bytes of the rows in these messages."),
    "msize_per_agent": _memory(
        "memory size (paper's msize)",
        "values",
        "Paper's size: 3 m_L + |A| m_s, or |A| m_Q; mean over agents.",
        whole=False,
    ),
    "bytes_per_intersection": Metric(
        "memory per intersection",
        "bytes",
        "True size of all memories per intersection.",
        digits=0,
        optional=True,
        stored=False,
        short=("memory bytes", "per intersection"),
    ),
}
"""All metrics, in the order in which they are columns of the table of runs."""

RUN_TABLE = (
    *("w_over_vc", "wait_per_spawned_s", "wait_per_visit_s", "wait_per_arrived_s"),
    *("travel_time_s", "mean_queue_veh", "throughput_veh_per_h", "spawned_veh", "arrived_veh"),
    *("entries_per_agent", "msize_per_agent", "bytes_per_intersection", "overruled"),
)
"""What ``dmil simulate`` shows."""
COMPARED = (
    *("travel_time_s", "delay_s", "wait_per_spawned_s"),
    *("stops_per_spawned", "person_delay_s", "co2_g"),
)
"""What ``dmil evaluate`` shows with differences: of these, less is better."""
COMPARISON_TABLE = (
    *COMPARED,
    *("throughput_veh_per_h", "mean_queue_veh"),
    *("overruled", "entries_per_agent", "bytes_per_intersection"),
)
"""All that it shows."""
COMPARISON_PAGE = (
    *("delay_s", "travel_time_s", "stops_per_spawned", "person_delay_s", "co2_g"),
    *("throughput_veh_per_h", "overruled"),
)
"""Columns of its report."""
NETWORK_PAGE = (
    *("delay_s", "travel_time_s", "wait_per_spawned_s", "stops_per_spawned", "mean_queue_veh"),
    *("throughput_veh_per_h", "co2_g", "fuel_g", "overruled"),
)
"""Columns of a network of the RESCO benchmark."""
SCORES = (*NETWORK_PAGE, "entries_per_agent", "bytes_total")
"""What the study on the benchmark has intervals of."""
JUDGED = tuple(name for name in dict.fromkeys(COMPARISON_TABLE + SCORES) if METRICS[name].better)
"""What controllers are judged by: the metrics of an episode in PettingZoo and Gymnasium."""
EPISODE = (
    *("delay_s", "travel_time_s", "wait_per_spawned_s", "mean_queue_veh"),
    *("entries_per_agent", "bytes_total"),
)
"""What is kept of every training episode."""
