"""When agents meet the central unit: the paper's periodic trigger rule (§IV-B)."""

from __future__ import annotations

from dmil.controllers.settings import LearnerSettings


class Meetings:
    """Keeps the time of the last meeting of a run.

    Parameters
    ----------
    settings
        Whether agents communicate, and how often.
    """

    def __init__(self, settings: LearnerSettings) -> None:
        self._period_s = settings.communication_period_s if settings.communication else 0
        self._held = 0

    def due(self, time_s: int) -> bool:
        """Tell whether another T seconds are over at this decision; true once per period."""
        if not self._period_s or time_s // self._period_s <= self._held:
            return False
        self._held = time_s // self._period_s
        return True
