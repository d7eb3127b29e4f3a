"""Protocols by name, each an exact recipe, as data."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from dmil.scenarios import SignalTiming


@dataclass(frozen=True, slots=True, kw_only=True)
class Protocol:
    """How controllers are judged somewhere; only figures under one protocol compare.

    All run in CityFlow, with the file's all-stop phase as clearance: at the beginning of an
    interval with a change, inside it.

    Parameters
    ----------
    decision_interval_s, clearance_s
        Signal timing in s.
    phases
        How many of the file's phases there are, the first ones; None: all.
    begins
        Whether all signals show their first phase before the run.
    measure
        Metric by its name in `dmil.results.metrics`.
    unfinished
        What happens to vehicles that have not arrived.
    source
        Who uses it, and what of it could not be found out.
    standing
        Whether a published rule gives the published figures here (``reproduced``), only parts of
        the recipe are published (``in part``), or it is ours.
    """

    decision_interval_s: int
    clearance_s: int
    phases: int | None = None
    begins: bool = False
    measure: str
    unfinished: str
    source: str
    standing: Literal["reproduced", "in part", "ours"]

    @property
    def timing(self) -> SignalTiming:
        """Its signal timing."""
        return SignalTiming(
            decision_interval_s=self.decision_interval_s,
            clearance_s=self.clearance_s,
            clearance_kind="all-stop",
        )


HORIZON_S = 3600
"""Length of a run in all of them: an hour, from second 0 of the file."""
WHOLE_TRIP, AT_LANES = "travel_time_s", "last_minus_first_s"
"""Measures: from scheduled departure to arrival; at intersections, as LLMLight counts."""
LLMLIGHT = "llmlight-30-5-4"
_ON_LANES = "on an entering lane at the end: 3,600 s less its first entering; outside: not counted"

PROTOCOLS: dict[str, Protocol] = {
    LLMLIGHT: Protocol(
        decision_interval_s=30,
        clearance_s=5,
        phases=4,
        begins=True,
        measure=AT_LANES,
        unfinished=_ON_LANES,
        source="LLMLight; EvoSignal's tables (2026)",
        standing="reproduced",
    ),
    "advanced-xlight-15-5": Protocol(
        decision_interval_s=15,
        clearance_s=5,
        begins=True,
        measure=AT_LANES,
        unfinished=_ON_LANES,
        source="interval and clearance of Advanced-XLight; the rest as in LLMLight, all phases: "
        "not verified",
        standing="in part",
    ),
    "coordlight-5-2": Protocol(
        decision_interval_s=5,
        clearance_s=2,
        begins=True,
        measure=AT_LANES,
        unfinished=_ON_LANES,
        source="interval and clearance of CoordLight; its measure could not be found out, "
        "LLMLight's stands in",
        standing="in part",
    ),
    "dmil-15-5": Protocol(
        decision_interval_s=15,
        clearance_s=5,
        measure=WHOLE_TRIP,
        unfinished="from departure up to the end of the run, those outside too",
        source="ours: the whole trip",
        standing="ours",
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
