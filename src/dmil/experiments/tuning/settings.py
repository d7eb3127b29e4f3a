"""How much is spent on tuning a controller, and what it is judged by."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from dmil.seeding import LARGEST_SEED

FACTOR = 3
"""One of so many candidates goes on to the next rung, with so many times the seeds (η)."""
RUNGS = 3

Metric = Literal["delay_s", "travel_time_s", "wait_per_spawned_s", "mean_queue_veh"]


class TuningSettings(BaseModel):
    """Tuning of controllers, the same for each of them."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    budget: int = Field(
        2000,
        ge=1,
        description="Total runs per controller, training included.",
    )
    seeds: int = Field(
        18,
        ge=2 * FACTOR ** (RUNGS - 1),
        le=10_000,
        multiple_of=FACTOR ** (RUNGS - 1),
        description="Tuning seeds of the last rung; earlier rungs have a ninth and a third.",
    )
    check_seeds: int = Field(
        20,
        ge=2,
        le=10_000,
        description="Further tuning seeds on which the best values are compared with the defaults.",
    )
    episodes: int = Field(
        10, ge=0, description="Training runs of a learner before the run that is scored."
    )
    frozen: bool = Field(
        False,
        description="Score learners frozen and greedy; by default they keep learning.",
    )
    metric: Metric = Field("delay_s", description="Metric to minimise.")
    seed: int = Field(
        0, ge=0, le=LARGEST_SEED, description="Master seed of the tuning seeds and of the search."
    )

    @property
    def rungs(self) -> tuple[int, ...]:
        """Tuning seeds of each rung, those of earlier rungs included."""
        return tuple(self.seeds // FACTOR**left for left in reversed(range(RUNGS)))

    def runs_per_seed(self, *, learns: bool) -> int:
        """Return the runs that one score costs."""
        return 1 + (self.episodes if learns else 0)

    def least_budget(self, *, learns: bool) -> int:
        """Return the runs for the defaults, the check and one candidate."""
        scores = self.seeds + 2 * self.check_seeds + self.seeds
        return scores * self.runs_per_seed(learns=learns)
