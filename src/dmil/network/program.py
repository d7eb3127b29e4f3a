"""The fixed-time plan that a file has for an intersection."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Stage:
    """One step of a fixed-time program (ours).

    Parameters
    ----------
    duration_s
        How long it lasts.
    green
        Local indices of the movements that may go, unsignalled ones left out; none or fewer during
        a clearance.
    clearance
        Whether it is yellow or all-red between two phases, even if somebody still has green.
    yellow
        Local indices of the movements that have yellow; none where the file does not tell yellow
        from red.
    others
        Whether only those go who are no vehicles, such as pedestrians.
    min_s, max_s
        How long it must and may last, None where the file does not say.
    """

    duration_s: float
    green: frozenset[int]
    clearance: bool = False
    yellow: frozenset[int] = frozenset()
    others: bool = False
    min_s: float | None = None
    max_s: float | None = None


@dataclass(frozen=True, slots=True)
class Program:
    """The fixed-time plan that a network's file has for an intersection (ours).

    Parameters
    ----------
    stages
        In order, clearance included; they repeat for ever.
    offset_s
        A time at which the cycle begins: at time t it stands at (t − offset_s) modulo its length.
    adaptive
        Whether SUMO makes the greens longer or shorter with the traffic (an actuated program); the
        queue simulator shows them as long as the file says.
    """

    stages: tuple[Stage, ...]
    offset_s: float = 0.0
    adaptive: bool = False

    @property
    def cycle_s(self) -> float:
        """Duration of all stages."""
        return sum(stage.duration_s for stage in self.stages)


def longest_clearance_s(stages: Sequence[tuple[float, bool]]) -> float:
    """Return the longest time of clearance on end in a cycle of (seconds, whether it clears)."""
    begin = next((k for k, (_, clears) in enumerate(stages) if not clears), 0)
    longest = run = 0.0
    for duration_s, clears in (*stages[begin:], *stages[:begin]):
        run = run + duration_s if clears else 0.0
        longest = max(longest, run)
    return longest
