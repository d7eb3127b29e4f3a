"""What the study of memories is to show, and the comparisons that decide it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Literal

from dmil.analysis.verdicts import Relation
from dmil.studies.memories.names import (
    LONGEST_QUEUE,
    LONGEST_QUEUE_APPROACHING,
    MAX_PRESSURE,
    PLANNER,
)

SUBJECT = "factored"
"""The memory that the bars are set for."""
SUBJECTS = (SUBJECT, "lookahead")
SINGLE = ("grid:1x1", "grid:1x1[*]3", "grid:1x1[*]7")
LIGHT = ("grid:3x3", "grid:5x5", "grid:5x5/unequal", "grid:5x5/time-varying")
HEAVY = ("grid:3x3[*]4", "grid:5x5[*]3", "grid:5x5[*]3.6")
CITIES = ("cityflow:*jinan*", "cityflow:*hangzhou*")
SEVERAL = (*LIGHT[:1], *HEAVY[:1], *LIGHT[1:2], *HEAVY[1:], *LIGHT[2:], *CITIES)
EVERYWHERE = (*SINGLE, *SEVERAL)
RIVALS = (
    "sarsa*",
    "dual-memory*",
    "mfec*",
    "plmp*",
    "dqn",
    "dqn-*",
    "dqn,*",
    "nec*",
    "vdn*",
)
SAME_WITHIN = 0.05
MOST_BYTES = 10_000


@dataclass(frozen=True, slots=True)
class Bar:
    """One claim and its rule.

    Parameters
    ----------
    name
        Short identifier.
    section
        Part of the report it belongs to.
    sentence
        What is claimed.
    cells
        Patterns of the cells that it is about; each has to match at least one.
    first
        Patterns of controllers, each of which has to show it.
    second
        Whom it is compared with; "" where a number is compared with the threshold.
    relation, threshold
        What each comparison has to show.
    measure
        "wait" for relative differences of waiting, "bytes" for bytes per intersection.
    """

    name: str
    section: Literal["bars", "limits", "rivals"]
    sentence: str
    cells: tuple[str, ...]
    first: tuple[str, ...]
    second: str
    relation: Relation
    threshold: float = 0.0
    measure: Literal["wait", "bytes"] = "wait"

    def cells_among(self, names: Sequence[str]) -> tuple[list[str], list[str]]:
        """Return the cells of a study that the claim is about, and the patterns without any."""
        found = [name for name in names if any(fnmatchcase(name, each) for each in self.cells)]
        lacking = [p for p in self.cells if not any(fnmatchcase(name, p) for name in names)]
        return found, lacking

    def first_among(self, names: Sequence[str]) -> list[str]:
        """Return the controllers of a study that the claim is about."""
        return [
            name
            for name in names
            if name != self.second and any(fnmatchcase(name, each) for each in self.first)
        ]


BARS: tuple[Bar, ...] = (
    Bar(
        "below-max-pressure",
        "bars",
        "Factored memory waits less than max-pressure on networks: light, heavy, unequal, "
        "time-varying and recorded demand.",
        SEVERAL,
        (SUBJECT,),
        MAX_PRESSURE,
        "below",
    ),
    Bar(
        "below-longest-queue",
        "bars",
        "Factored memory waits less than longest queue first on the same.",
        SEVERAL,
        (SUBJECT,),
        LONGEST_QUEUE,
        "below",
    ),
    Bar(
        "nowhere-above-max-pressure",
        "bars",
        "Nowhere does factored memory wait longer than max-pressure, one intersection included.",
        EVERYWHERE,
        (SUBJECT,),
        MAX_PRESSURE,
        "not above",
    ),
    Bar(
        "nowhere-above-longest-queue",
        "bars",
        "Nowhere does factored memory wait longer than longest queue first.",
        EVERYWHERE,
        (SUBJECT,),
        LONGEST_QUEUE,
        "not above",
    ),
    Bar(
        "fifteen-percent",
        "bars",
        "Factored memory waits at least 15 % less than max-pressure on 5×5 ×1.",
        ("grid:5x5",),
        (SUBJECT,),
        MAX_PRESSURE,
        "below",
        -0.15,
    ),
    Bar(
        "below-approaching",
        "bars",
        "Factored memory waits less than longest queue first that sees approaching vehicles, too, "
        "where demand is light, unequal or varies with time.",
        LIGHT,
        (SUBJECT,),
        LONGEST_QUEUE_APPROACHING,
        "below",
    ),
    Bar(
        "nowhere-above-approaching",
        "bars",
        "Nowhere does it wait longer than longest queue first that sees approaching vehicles, too.",
        EVERYWHERE,
        (SUBJECT,),
        LONGEST_QUEUE_APPROACHING,
        "not above",
    ),
    Bar(
        "ten-kilobytes",
        "bars",
        "Factored memory takes less than 10 kB per intersection, in the largest of all runs.",
        EVERYWHERE,
        (SUBJECT,),
        "",
        "below",
        MOST_BYTES,
        "bytes",
    ),
    Bar(
        "nobody-beats-the-future",
        "limits",
        "On one intersection nobody waits less than a planner that knows all arrivals.",
        SINGLE,
        ("*",),
        PLANNER,
        "not below",
    ),
    Bar(
        "rivals-above-max-pressure",
        "rivals",
        "No memory that the paper names waits less than max-pressure, which remembers nothing.",
        EVERYWHERE,
        RIVALS,
        MAX_PRESSURE,
        "not below",
    ),
    Bar(
        "rivals-above-factored",
        "rivals",
        "Every memory that the paper names waits longer than factored memory.",
        EVERYWHERE,
        RIVALS,
        SUBJECT,
        "above",
    ),
    Bar(
        "exact-states-never-recur",
        "rivals",
        "Exact states hardly ever recur under load: SARSA on them waits as long as random "
        "choice, within 10 %.",
        ("grid:5x5", "grid:5x5[*]3", "grid:5x5[*]3.6"),
        ("sarsa", "sarsa,epsilon=*"),
        "random",
        "within",
        0.10,
    ),
    Bar(
        "classes-carry-the-gain",
        "rivals",
        "The gain is generalisation: SARSA on complex classes waits less than on exact states.",
        EVERYWHERE,
        ("sarsa,embedding=complex*",),
        "sarsa,epsilon=0.05",
        "below",
    ),
    Bar(
        "two-memories-neutral",
        "rivals",
        "Splitting the paper's memory in short and long term changes waiting by less than 5 %.",
        EVERYWHERE,
        ("dual-memory,epsilon=0.05",),
        "sarsa,embedding=complex,epsilon=0.05",
        "within",
        SAME_WITHIN,
    ),
    Bar(
        "prioritised-helps",
        "rivals",
        "Prioritised replay waits less than uniform replay (Schaul et al. 2016).",
        EVERYWHERE,
        ("dqn-prioritised*",),
        "dqn",
        "below",
    ),
    Bar(
        "hindsight-helps",
        "rivals",
        "Hindsight replay waits less than uniform replay (Andrychowicz et al. 2017).",
        EVERYWHERE,
        ("dqn-hindsight*",),
        "dqn",
        "below",
    ),
    Bar(
        "learned-keys-help",
        "rivals",
        "Keys that are learned wait less than raw counts: NEC below MFEC (Pritzel et al. 2016).",
        EVERYWHERE,
        ("nec*",),
        "mfec",
        "below",
    ),
    Bar(
        "team-value-helps",
        "rivals",
        "A team's value, VDN, waits less than DQN, where every intersection learns for itself.",
        SEVERAL,
        ("vdn*",),
        "dqn",
        "below",
    ),
)
"""The bars that were set before the study was run, the limit, and what is said of the rivals."""
