"""When agents meet the central unit, and what becomes of their messages.

The paper's rule is the periodic one (§IV-B); its future work names other triggers, and delays of
the synchronisation. These, and messages that are lost, are ours.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dmil.arrays import FloatArray, IntArray
from dmil.controllers.tabular.settings import DualMemorySettings, LearnerSettings
from dmil.memory import Merged

ROWS, CHANGE, STAGED = range(3)
"""Columns of the news: new rows of the Q-table or of short-term memory, where all that is new
enters first; the sum of |ΔQ| over all writes; how often short-term memory was staged."""
NEWS = 3
"""How many columns they are."""


class CentralReply(NamedTuple):
    """What the central unit sent to the agents of one shape.

    Attributes
    ----------
    due_s: int
        When it arrives.
    merged: Merged
        What it says.
    reached: (agents,) int32
        The agents that receive it.
    """

    due_s: int
    merged: Merged
    reached: IntArray


class Meetings:
    """Decides when the agents of each shape meet.

    Parameters
    ----------
    settings
        The trigger, and its threshold.
    shapes
        How many shapes of intersections there are.
    """

    def __init__(self, settings: LearnerSettings, shapes: int) -> None:
        self._settings = settings
        self._share = settings.trigger_share if isinstance(settings, DualMemorySettings) else 1.0
        self._held = np.zeros(shapes, np.int64)

    def due(self, shape: int, time_s: int, news: FloatArray, members: IntArray) -> bool:
        """Tell whether the agents of a shape meet at this decision; true once per period.

        Parameters
        ----------
        shape
            Which shape.
        time_s
            Time of the decision.
        news: (agents, 3) float64
            What agents have stored since they last met; see `ROWS` and its neighbours.
        members: (members,) int
            The agents of the shape.
        """
        settings = self._settings
        if settings.trigger == "entries":
            return bool(news[members, ROWS].mean() >= settings.trigger_entries)
        if settings.trigger == "values":
            return bool(news[members, CHANGE].mean() >= settings.trigger_change)
        if settings.trigger == "staging":
            return bool((news[members, STAGED] > 0).mean() >= self._share)
        periods = time_s // settings.communication_period_s
        is_due = bool(periods > self._held[shape])
        self._held[shape] = periods
        return is_due


class Post:
    """Carries the messages of one run: loses some, and counts all.

    Parameters
    ----------
    loss: float
        Chance that a message is lost.
    rng
        The controller's stream of chance; losses have a stream of their own, so that exploration
        is the same with and without them.
    """

    def __init__(self, loss: float, rng: np.random.Generator) -> None:
        self._loss = loss
        self._rng = rng.spawn(1)[0] if loss else None
        self.messages = 0
        self.exchanged_bytes = 0

    def arrived(self, members: IntArray) -> tuple[IntArray, IntArray]:
        """Return the agents whose messages reach the central unit, and those that get its answers.

        Parameters
        ----------
        members: (members,) int32
            Agents that meet.

        Returns
        -------
        heard, reached: (some,) int32
        """
        if self._rng is None:
            return members, members
        arrives: npt.NDArray[np.bool_] = self._rng.random((2, members.size)) >= self._loss
        return members[arrives[0]], members[arrives[1]]

    def count(self, messages: int, size_bytes: int) -> None:
        """Count messages that are sent, whether or not they arrive, and their bytes together."""
        self.messages += messages
        self.exchanged_bytes += size_bytes
