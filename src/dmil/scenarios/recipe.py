"""A scenario as a user asks for it: a name or two files, and what to change about it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from dmil.demand import Ties
from dmil.demand.recorded import SHIFT_S
from dmil.errors import InputError
from dmil.interpretations import mark
from dmil.network.grid import ENTRY_LINK_TIME_S, LINK_TIME_S
from dmil.network.sumo.reader import Phases
from dmil.scenarios.calibration import load_calibration
from dmil.scenarios.cityflow import cityflow_scenario
from dmil.scenarios.demand_changes import DemandChanges, resampled, with_ties
from dmil.scenarios.model import HIGHEST_LOAD, LONGEST_RUN_S, QueueDynamics, Routing, Scenario
from dmil.scenarios.registry import scenario, with_load
from dmil.scenarios.sumo import sumo_scenario
from dmil.scenarios.sumo_configuration import SumoConfiguration
from dmil.scenarios.timing import ClearanceKind, SignalTiming

LONGEST_LINK_S = 3600.0
"""Longest time on a grid's link: an hour."""


def _changed(kind: type[BaseModel], name: str) -> Any:
    """Offer a field of a scenario's settings for change: the same limits and text, no default."""
    original = kind.model_fields[name]
    field: Any = Field(None, description=original.description)
    field.metadata = list(original.metadata)
    return field


class TimingChanges(BaseModel):
    """Signal timing that differs from the scenario's own."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    decision_interval_s: int | None = _changed(SignalTiming, "decision_interval_s")
    clearance_s: int | None = _changed(SignalTiming, "clearance_s")
    all_red_s: int | None = _changed(SignalTiming, "all_red_s")
    clearance_kind: ClearanceKind | None = _changed(SignalTiming, "clearance_kind")
    min_green_s: int | None = _changed(SignalTiming, "min_green_s")
    max_green_s: int | None = _changed(SignalTiming, "max_green_s")
    startup_lost_s: int | None = _changed(SignalTiming, "startup_lost_s")


class DynamicsChanges(BaseModel):
    """Queue dynamics that differ from the scenario's own."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    saturation_flow_veh_per_s: float | None = _changed(QueueDynamics, "saturation_flow_veh_per_s")
    storage: bool | None = _changed(QueueDynamics, "storage")
    vehicle_space_m: float | None = _changed(QueueDynamics, "vehicle_space_m")
    gap_wait_s: int | None = _changed(QueueDynamics, "gap_wait_s")
    start_wave_veh_per_s: float | None = _changed(QueueDynamics, "start_wave_veh_per_s")


class GridChanges(BaseModel):
    """Links of a grid that differ from the usual."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    link_time_s: float | None = Field(
        None,
        ge=0,
        le=LONGEST_LINK_S,
        allow_inf_nan=False,
        description=f"Seconds on a link between intersections, by default {LINK_TIME_S:g} "
        f"{mark('grid.link_time_s')}.",
    )
    entry_link_time_s: float | None = Field(
        None,
        ge=0,
        le=LONGEST_LINK_S,
        allow_inf_nan=False,
        description="Seconds on an entry link and on an exit link, by default "
        f"{ENTRY_LINK_TIME_S:g} {mark('grid.entry_link_time_s')}.",
    )


class ScenarioRecipe(BaseModel):
    """What a scenario is made from; as JSON it is small, while a scenario holds whole networks."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    scenario: str | None = Field(
        None, description="Name of the scenario, such as grid:5x5 or cityflow:FOLDER."
    )
    roadnet: Path | None = Field(
        None, description="Road network in CityFlow format; with --flow, replaces --scenario."
    )
    flow: Path | None = Field(None, description="Vehicles in CityFlow format, on that network.")
    net: Path | None = Field(
        None, description="SUMO road network (.net.xml); with --routes, replaces --scenario."
    )
    routes: tuple[Path, ...] = Field(
        (), description="SUMO route files (.rou.xml) on that network: vehicles, trips, flows."
    )
    additional: tuple[Path, ...] = Field((), description="SUMO additional files (.add.xml).")
    begin_s: int | None = Field(
        None,
        ge=0,
        le=LONGEST_RUN_S,
        description="SUMO time at which a run begins, in s; by default that of the configuration, "
        "or 0.",
    )
    phases: Phases | None = Field(
        None,
        description="Phases of a SUMO network: program (those of its signal programs, the "
        "default) or derived (from movements that do not conflict).",
    )
    routing: Routing | None = Field(
        None,
        description="Routing of SUMO's trips: sumo (one run of SUMO with congestion, the default "
        "where it is installed), mesoscopic (the same with its mesoscopic model, in a tenth "
        "of the time) or free-flow.",
    )
    horizon_s: int | None = Field(
        None,
        ge=1,
        le=LONGEST_RUN_S,
        description="Length of a run in s; by default 300 on grids; for recorded vehicles until "
        "the last departure, rounded up to 600 s.",
    )
    load: float = Field(
        1.0,
        ge=0,
        le=HIGHEST_LOAD,
        allow_inf_nan=False,
        description="Factor on the demand; 2 means twice as many vehicles.",
    )
    resample: bool = Field(
        False,
        description="Bootstrap the recorded vehicles for every seed: as many vehicles, some "
        "twice, some not at all, with departures shifted slightly.",
    )
    resample_shift_s: int | None = Field(
        None,
        ge=0,
        le=LONGEST_RUN_S,
        description=f"Maximum shift of a departure in s, by default {SHIFT_S}.",
    )
    ties: Ties | None = Field(
        None,
        description="Choice between equally short routes of random arrivals: straight (straight "
        "on first, which gives one route per pair of nodes on a grid; the default) or coin (a "
        "fair coin at every choice, drawn in advance).",
    )
    calibration: Path | None = Field(
        None,
        description="Calibration of the queue simulator, from dmil calibrate.",
    )
    ignore_junction_blocker_s: int | None = Field(
        None,
        ge=1,
        le=LONGEST_RUN_S,
        description="SUMO: seconds after which a vehicle that stands on a junction blocks others "
        "no more; by default never, so that a junction can lock for good.",
    )
    timing: TimingChanges = Field(TimingChanges(), description="Signal timing.")
    dynamics: DynamicsChanges = Field(DynamicsChanges(), description="Queue dynamics.")
    demand: DemandChanges = Field(
        DemandChanges(), description="Random arrivals in place of the scenario's own demand."
    )
    grid: GridChanges = Field(GridChanges(), description="Links of a grid.")

    def build(self) -> Scenario:
        """Make the scenario (ours).

        Raises
        ------
        InputError
            If it is not said which, its files or the changes are not valid, or the calibration is
            that of another network.
        """
        made = self._named()
        made = replace(made, demand=self.demand.applied_to(made.demand, made.network))
        if self.ties is not None:
            made = replace(made, demand=with_ties(made.demand, self.ties, made.network))
        made = with_load(made, self.load)
        if self.resample or self.resample_shift_s is not None:
            shift_s = SHIFT_S if self.resample_shift_s is None else self.resample_shift_s
            made = replace(made, demand=resampled(made.demand, shift_s))
        if self.calibration is not None:
            made = load_calibration(self.calibration).applied_to(made)
        return replace(
            made,
            timing=SignalTiming(**made.timing.model_dump() | _given(self.timing)),
            ignore_junction_blocker_s=self.ignore_junction_blocker_s,
            dynamics=QueueDynamics(**made.dynamics.model_dump() | _given(self.dynamics)),
        )

    def _named(self) -> Scenario:
        given = [
            name for name in ("scenario", "roadnet", "flow", "net", "routes") if getattr(self, name)
        ]
        if given == ["scenario"]:
            return scenario(
                str(self.scenario),
                horizon_s=self.horizon_s,
                begin_s=self.begin_s,
                phases=self.phases,
                routing=self.routing,
                link_time_s=self.grid.link_time_s,
                entry_link_time_s=self.grid.entry_link_time_s,
            )
        if _given(self.grid):
            raise InputError(
                "the links of these files have times of their own",
                where=f"grid: {', '.join(_given(self.grid))}",
                expected="a grid where these are given",
                mend="leave them out",
            )
        if given == ["roadnet", "flow"] and self.roadnet and self.flow:
            others = ("begin_s", "phases", "routing")
            if all(getattr(self, name) is None for name in others):
                return cityflow_scenario(self.roadnet, self.flow, horizon_s=self.horizon_s)
            given += [name for name in others if getattr(self, name) is not None]
        if given == ["net", "routes"] and self.net:
            return sumo_scenario(
                SumoConfiguration(self.net, self.routes, self.additional),
                begin_s=self.begin_s,
                horizon_s=self.horizon_s,
                phases=self.phases or "program",
                routing=self.routing,
            )
        given += ["additional"] if self.additional else []
        raise InputError(
            f"only {given[0]}" if len(given) == 1 else " and ".join(given) or "none is given",
            where="scenario",
            expected="either the name of a scenario, such as grid:5x5, or both roadnet and flow, "
            "or both net and routes",
        )


def _given(changes: BaseModel) -> dict[str, Any]:
    return changes.model_dump(exclude_none=True)
