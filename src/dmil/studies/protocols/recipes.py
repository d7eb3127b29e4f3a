"""Published protocols by name, each an exact recipe, as data."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from dmil.scenarios import SignalTiming
from dmil.scenarios.timing import ClearanceKind


@dataclass(frozen=True, slots=True, kw_only=True)
class Protocol:
    """How controllers are judged somewhere; only figures under one protocol compare.

    Parameters
    ----------
    simulator
        Where it is run.
    decision_interval_s, clearance_s, clearance_kind
        Signal timing; the clearance is at the beginning of an interval with a change, inside it.
    phases
        How many of the file's phases there are, the first ones; None: all.
    begins
        Whether all signals show their first phase before the run.
    measure
        Metric by its name in `dmil.results.metrics`.
    unfinished
        What happens to vehicles that have not arrived.
    source
        Who uses it.
    reproduced
        Whether a published rule gives the published figures here.
    """

    simulator: Literal["cityflow", "sumo"] = "cityflow"
    decision_interval_s: int
    clearance_s: int
    clearance_kind: ClearanceKind | None = "all-stop"
    phases: int | None = None
    begins: bool = False
    measure: str
    unfinished: str
    source: str
    reproduced: bool = False

    @property
    def timing(self) -> SignalTiming:
        """Its signal timing."""
        return SignalTiming(
            decision_interval_s=self.decision_interval_s,
            clearance_s=self.clearance_s,
            clearance_kind=self.clearance_kind,
        )


HORIZON_S = 3600
"""Length of a run in all of them: an hour, from second 0 of the file."""
_AT_LANES = (
    "on an entering lane at the end: as if it left at the end; outside: not counted",
    "LLMLight (Lai et al. 2023) and EvoSignal (2026)",
)
_SUMO = "up to the end of the run, those that never departed too"

PROTOCOLS: dict[str, Protocol] = {
    "llmlight-30-5-4": Protocol(
        decision_interval_s=30,
        clearance_s=5,
        phases=4,
        begins=True,
        measure="last_minus_first_s",
        unfinished=_AT_LANES[0],
        source=_AT_LANES[1],
        reproduced=True,
    ),
    "advanced-15-5-8": Protocol(
        decision_interval_s=15,
        clearance_s=5,
        begins=True,
        measure="last_minus_first_s",
        unfinished=_AT_LANES[0],
        source="Advanced-XLight (Zhang et al. 2022), eight phases",
    ),
    "coordlight-5-2": Protocol(
        decision_interval_s=5,
        clearance_s=2,
        begins=True,
        measure="last_minus_first_s",
        unfinished=_AT_LANES[0],
        source="CoordLight (2025); its measure could not be found out",
    ),
    "dmil-15-5": Protocol(
        decision_interval_s=15,
        clearance_s=5,
        measure="travel_time_s",
        unfinished="from departure up to the end of the run, those outside too",
        source="ours: the whole trip",
    ),
    "resco-10-3": Protocol(
        simulator="sumo",
        decision_interval_s=10,
        clearance_s=3,
        clearance_kind=None,
        measure="delay_s",
        unfinished=_SUMO,
        source="RESCO (Ault and Sharon 2021)",
    ),
    "resco-arterial-5-2": Protocol(
        simulator="sumo",
        decision_interval_s=5,
        clearance_s=2,
        clearance_kind=None,
        measure="delay_s",
        unfinished=_SUMO,
        source="RESCO's configuration of arterial4x4",
    ),
}
"""All protocols."""
CITIES: dict[str, tuple[str, str]] = {
    "JN1": ("jinan_3x4", "anon_3_4_jinan_real.json"),
    "JN2": ("jinan_3x4", "anon_3_4_jinan_real_2000.json"),
    "JN3": ("jinan_3x4", "anon_3_4_jinan_real_2500.json"),
    "HZ1": ("hangzhou_4x4", "anon_4_4_hangzhou_real.json"),
    "HZ2": ("hangzhou_4x4", "anon_4_4_hangzhou_real_5816.json"),
}
"""Short name, as publications have it, to folder and flow file of a city's day."""
