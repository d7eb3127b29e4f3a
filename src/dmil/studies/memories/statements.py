"""What the study of memories is to show, and the comparisons that decide it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Literal

from dmil.analysis.claims import Claim, Question, Relation
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


Measure = Literal["wait", "bytes"]


@dataclass(frozen=True, slots=True)
class Pairs:
    """Which controllers are compared where.

    Attributes
    ----------
    cells, first
        Patterns of cells, each of which has to match at least one, and of controllers, each of
        which has to show it.
    second: str
        Controller it is compared with; "" where a number is compared with the threshold.
    measure: str
        "wait" for relative differences of waiting, "bytes" for bytes per intersection.
    """

    cells: tuple[str, ...]
    first: tuple[str, ...]
    second: str
    measure: Measure = "wait"

    def cells_among(self, names: Sequence[str]) -> tuple[list[str], list[str]]:
        """Return the cells of a study that it is about, and the patterns without any."""
        lacking = [p for p in self.cells if not any(fnmatchcase(name, p) for name in names)]
        return _matching(names, self.cells), lacking

    def first_among(self, names: Sequence[str]) -> list[str]:
        """Return the controllers of a study that it is about."""
        return [name for name in _matching(names, self.first) if name != self.second]


def _matching(names: Sequence[str], patterns: Sequence[str]) -> list[str]:
    return [name for name in names if any(fnmatchcase(name, each) for each in patterns)]


def _claim(
    name: str,
    sentence: str,
    asked: tuple[Relation, str, tuple[str, ...]],
    threshold: float = 0.0,
    *,
    first: tuple[str, ...] = (SUBJECT,),
    kind: Literal["bars", "limits", "rivals"] = "bars",
    measure: Measure = "wait",
) -> Claim[Pairs]:
    """Return a claim; what is asked: which relation, with whom it is compared, in which cells."""
    relation, second, cells = asked
    percent = f"{100 * threshold:+.0f} %".replace("-", "−").replace("+0 %", "0")
    if relation == "within":
        percent = percent.replace("+", "±")
    rule = f"95 % interval of the paired difference {relation} {percent}, in every cell"
    if measure == "bytes":
        rule = f"bytes per intersection {relation} {threshold:,.0f} in every run"
    question = Question(rule, Pairs(cells, first, second, measure), relation, threshold)
    return Claim(name, kind, sentence, (question,))


def _rival(
    name: str,
    sentence: str,
    first: tuple[str, ...],
    asked: tuple[Relation, str, tuple[str, ...]],
    threshold: float = 0.0,
) -> Claim[Pairs]:
    """Return a claim on other memories."""
    return _claim(name, sentence, asked, threshold, first=first, kind="rivals")


BARS: tuple[Claim[Pairs], ...] = (
    _claim(
        "below-max-pressure",
        "Factored memory waits less than max-pressure on networks: light, heavy, unequal, "
        "time-varying and recorded demand.",
        ("below", MAX_PRESSURE, SEVERAL),
    ),
    _claim(
        "below-longest-queue",
        "Factored memory waits less than longest queue first on the same networks.",
        ("below", LONGEST_QUEUE, SEVERAL),
    ),
    _claim(
        "nowhere-above-max-pressure",
        "Factored memory never waits longer than max-pressure, single intersections included.",
        ("not above", MAX_PRESSURE, EVERYWHERE),
    ),
    _claim(
        "nowhere-above-longest-queue",
        "Factored memory never waits longer than longest queue first.",
        ("not above", LONGEST_QUEUE, EVERYWHERE),
    ),
    _claim(
        "fifteen-percent",
        "Factored memory waits at least 15 % less than max-pressure on 5×5 ×1.",
        ("below", MAX_PRESSURE, ("grid:5x5",)),
        -0.15,
    ),
    _claim(
        "below-approaching",
        "Factored memory also waits less than longest queue first with approaching "
        "vehicles where demand is light, unequal or time-varying.",
        ("below", LONGEST_QUEUE_APPROACHING, LIGHT),
    ),
    _claim(
        "nowhere-above-approaching",
        "It never waits longer than longest queue first with approaching vehicles.",
        ("not above", LONGEST_QUEUE_APPROACHING, EVERYWHERE),
    ),
    _claim(
        "ten-kilobytes",
        "Factored memory takes less than 10 kB per intersection in every run.",
        ("below", "", EVERYWHERE),
        MOST_BYTES,
        measure="bytes",
    ),
    _claim(
        "nobody-beats-the-future",
        "On one intersection no controller waits less than a planner that knows all arrivals.",
        ("not below", PLANNER, SINGLE),
        first=("*",),
        kind="limits",
    ),
    _rival(
        "rivals-above-max-pressure",
        "No memory that the paper names waits less than max-pressure, which remembers nothing.",
        RIVALS,
        ("not below", MAX_PRESSURE, EVERYWHERE),
    ),
    _rival(
        "rivals-above-factored",
        "Every memory that the paper names waits longer than factored memory.",
        RIVALS,
        ("above", SUBJECT, EVERYWHERE),
    ),
    _rival(
        "exact-states-never-recur",
        "Exact states rarely recur under load: SARSA on them waits as long as random "
        "choice, within 10 %.",
        ("sarsa", "sarsa,epsilon=*"),
        ("within", "random", ("grid:5x5", "grid:5x5[*]3", "grid:5x5[*]3.6")),
        0.10,
    ),
    _rival(
        "classes-carry-the-gain",
        "The gain is generalisation: SARSA on complex classes waits less than on exact states.",
        ("sarsa,embedding=complex*",),
        ("below", "sarsa,epsilon=0.05", EVERYWHERE),
    ),
    _rival(
        "two-memories-neutral",
        "Splitting the paper's memory into short and long term changes waiting by less than 5 %.",
        ("dual-memory,epsilon=0.05",),
        ("within", "sarsa,embedding=complex,epsilon=0.05", EVERYWHERE),
        SAME_WITHIN,
    ),
    _rival(
        "prioritised-helps",
        "Prioritised replay waits less than uniform replay (Schaul et al. 2016).",
        ("dqn-prioritised*",),
        ("below", "dqn", EVERYWHERE),
    ),
    _rival(
        "hindsight-helps",
        "Hindsight replay waits less than uniform replay (Andrychowicz et al. 2017).",
        ("dqn-hindsight*",),
        ("below", "dqn", EVERYWHERE),
    ),
    _rival(
        "learned-keys-help",
        "Learned keys wait less than raw counts: NEC below MFEC (Pritzel et al. 2016).",
        ("nec*",),
        ("below", "mfec", EVERYWHERE),
    ),
    _rival(
        "team-value-helps",
        "A team value, VDN, waits less than DQN, where every intersection learns alone.",
        ("vdn*",),
        ("below", "dqn", SEVERAL),
    ),
)
"""The bars that were set before the study was run, the limit, and what is said of the rivals."""
