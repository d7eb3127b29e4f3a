"""The page about metrics: what each means, and how each simulator counts what it is made of."""

from __future__ import annotations

from dmil.results.metrics import METRICS, Metric

COUNTING: dict[str, tuple[str, str]] = {
    "spawned_veh": (
        "vehicles whose departure time has come",
        "the same vehicles, by their scheduled departure",
    ),
    "arrived_veh": (
        "vehicles that have reached the end of their last link",
        "`tripinfo` of the vehicles that have ended their trip",
    ),
    "wait_veh_s": (
        "every second, the vehicles in queues at stop lines and those that wait outside for room",
        "`waitingTime`, the seconds below 0.1 m/s, and `departDelay`; also of vehicles under way",
    ),
    "visits": (
        "times that a vehicle came to a stop line with signals",
        "links with signals at their end that vehicles came to",
    ),
    "arrived_wait_veh_s": (
        "seconds that the arrived vehicles waited",
        "`waitingTime` and `departDelay` of the arrived vehicles",
    ),
    "travel_veh_s": (
        "from departure to arrival, or to the end of the run",
        "from the scheduled departure to `arrival`, or to the end of the run",
    ),
    "time_loss_veh_s": (
        "seconds in queues; calibrated, also what links that were crossed take longer than in free "
        "flow",
        "`timeLoss`, against driving at the speed that vehicle and road allow; also of vehicles "
        "under way",
    ),
    "departure_delay_veh_s": (
        "seconds outside for want of room; none where links hold any number of vehicles",
        "`departDelay`; for vehicles that are not in yet, the time since their scheduled departure",
    ),
    "stops": (
        "times that a vehicle joined a queue and stayed for at least a second",
        "`waitingCount`: times that a vehicle fell below 0.1 m/s, also of vehicles under way",
    ),
    "overruled": (
        "phase requests rejected by the signal timing rules",
        "the same, by the same rules: both simulators share them",
    ),
    "arrived_at": ("counted after every second", "from `arrival`"),
    "queued_at": (
        "vehicles in queues and outside, counted after every second",
        "vehicles below 0.1 m/s at every decision, in between interpolated, and those outside",
    ),
    "co2_g": ("not known", "`CO2_abs` of SUMO's emission model, by its vehicle types"),
    "fuel_g": ("not known", "`fuel_abs`, likewise"),
    "last_minus_first_s": ("not known", "not known; in CityFlow from the lanes in every second"),
    "entering_lanes_s": ("not known", "not known; in CityFlow likewise"),
    "person_delay_s": ("nobody walks", "`waitingTime` of `personinfo`, the seconds below 0.1 m/s"),
}
"""Raw count of `dmil.simulation.measures.Measures` to how it comes about: queue simulator, SUMO."""


def metrics_markdown() -> str:
    """Return the documentation of all metrics as Markdown (ours)."""
    lines = ["| metric | column | unit | better | definition |", "|-|-|-|-|-|"]
    lines += [
        f"| {each.label}{_only(each)} | `{name}` | {each.unit} "
        f"| {each.better or ''} | {each.meaning} |"
        for name, each in METRICS.items()
    ]
    lines += [
        "",
        "## How the simulators count",
        "",
        "| count | queue simulator | SUMO |",
        "|-|-|-|",
    ]
    lines += [
        f"| `{name}` | {in_queue} | {in_sumo} |" for name, (in_queue, in_sumo) in COUNTING.items()
    ]
    return "\n".join(lines) + "\n"


def _only(metric: Metric) -> str:
    if metric.sumo_only:
        return ", in SUMO only"
    return ", in CityFlow only" if metric.cityflow_only else ""
