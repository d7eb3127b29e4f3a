"""Initial tables of agents: the Q-table of the dummy agent from the training phase."""

from __future__ import annotations

from dataclasses import dataclass

from dmil.memory import ValueTable


@dataclass(frozen=True, slots=True, eq=False)
class Prior:
    """An exact Q-table of states, one owner per shape of intersection (paper, §VI-B).

    Equal only to itself, so that what is derived from it can be kept and shared.

    Attributes
    ----------
    table: ValueTable
    """

    table: ValueTable
