"""What a comparison answers to somebody who asks which controller to use."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dmil.controllers import CONTROLLERS
from dmil.experiments.comparison import Comparison

METRIC = "delay_s"
"""What contenders are ranked by."""
PLAN = "program"
NO_RIVALS = tuple(name for name, entry in CONTROLLERS.items() if entry.oracle)
"""Controllers that cannot be deployed: they know all future arrivals."""


def answer(found: Comparison) -> str:
    """Say in one or two sentences which contender to use.

    Those whose paired difference to the one with the least mean delay has an interval with 0 in it
    are level with it, unless they lock in some seeds and it does not, or it is shown to beat the
    network's own plan and they are not. On one recorded day, or in one seed, it says no more than
    what was seen.
    """
    if found.withheld:
        return "No recommendation: the comparison is not fair."
    values = found.measures[METRIC].mean(axis=0)
    usable = [
        i
        for i in np.argsort(values, kind="stable").tolist()
        if values[i] == values[i] and _name(found.labels[i]) not in NO_RIVALS
    ]
    if not usable:
        return "No recommendation: no vehicle departed."
    best = usable[0]
    plan = next((i for i in usable if _name(found.labels[i]) == PLAN), None)
    if len(usable) == 1:
        text = f"{_called(found.labels[best])} is alone: there is nothing to compare it with."
    elif found.one_day or len(found.seeds) == 1:
        text = _seen(found, usable, plan)
    else:
        text = _shown(found, usable, plan)
    return text + _warning(found, usable[0])


def locked_notes(found: Comparison) -> list[str]:
    """Name the runs in which a junction locked, one sentence for a contender."""
    notes = []
    for label in found.labels:
        runs = {seed: one for (each, seed), one in found.locked.items() if each == label}
        if not runs:
            continue
        places: dict[str, list[int]] = {}
        for one in runs.values():
            places.setdefault(one[0].junction, []).append(one[0].since_s)
        where = "; ".join(
            f"at junction {junction} from {min(since_s):,} s on"
            + (f" (the earliest of {len(since_s)})" if len(since_s) > 1 else "")
            for junction, since_s in places.items()
        )
        more = max(len(one) for one in runs.values()) - 1
        behind = f", with up to {more} more behind it" if more else ""
        notes.append(f"{label}: {len(runs)} of {len(found.seeds)} seeds locked {where}{behind}.")
    return notes


def _name(label: str) -> str:
    return label.partition(",")[0]


def _called(label: str) -> str:
    """Return a label as it reads in a sentence."""
    return label.replace(",approaching=true", " with approaching")


def _listed(names: Sequence[str]) -> str:
    called = [_called(name) for name in names]
    return called[0] if len(called) == 1 else f"{', '.join(called[:-1])} and {called[-1]}"


def _seen(found: Comparison, usable: list[int], plan: int | None) -> str:
    """Tell what one day, or one seed, was like, without a verdict."""
    values = found.measures[METRIC].mean(axis=0)
    least = [found.labels[i] for i in usable if f"{values[i]:.1f}" == f"{values[usable[0]]:.1f}"]
    when = "On this one day" if found.one_day else "In this one seed"
    verb = "have" if len(least) > 1 else "has"
    beside = ""
    if plan is not None and found.labels[plan] not in least:
        beside = f"; your plan has {values[plan]:.1f} s"
    mend = "--resample for other days like it" if found.same_demand else "--seeds 10"
    return (
        f"{when} {_listed(least)} {verb} the least delay, {values[usable[0]]:.1f} s per "
        f"vehicle{beside}. For a verdict add {mend}."
    )


def _shown(found: Comparison, usable: list[int], plan: int | None) -> str:
    """Tell what the intervals of paired differences show."""
    best = usable[0]
    difference = found.difference(METRIC, found.labels[best])
    assert difference is not None, "the best one is in the comparison"
    level = [i for i in usable if i == best or difference.low[i] <= 0]
    # A mean that one locked run makes uncertain is no reason to call its controller as good.
    if not _locks(found, best):
        level = [i for i in level if not _locks(found, i)]
    names = [found.labels[i] for i in level]
    where = " On this one recorded day, that is: --resample tries others." * found.same_demand
    if plan in level:
        others = [found.labels[i] for i in level if i != plan]
        if others:
            verb = "are" if len(others) > 1 else "is"
            return f"Nothing is shown to beat your plan: {_listed(others)} {verb} level.{where}"
        return f"Keep your plan: it has less delay than all others.{where}"
    value = found.measures[METRIC].mean(axis=0)[best]
    gain = ""
    if plan is not None:
        cut = found.difference(METRIC, found.labels[plan])
        assert cut is not None, "the plan is in the comparison"
        low, high = sorted((-cut.low[best], -cut.high[best]))
        if cut.high[best] < 0:
            # Who is not shown to beat the plan is no equal of one that is.
            names = [found.labels[i] for i in level if cut.high[i] < 0]
        gain = f", {-cut.value[best]:.1f} s [{low:.1f}, {high:.1f}] less than your plan"
    if len(names) == 1:
        least = f"it has the least delay, {value:.1f} s per vehicle{gain}"
        return f"Use {_called(names[0])}: {least}.{where}"
    rules = [name for name in names if _is_rule(name)]
    simple = ""
    if rules and len(rules) < len(names):
        simple = f" Of these {_called(rules[0])} is the simplest: it learns nothing."
    return (
        f"{_listed(names)} are level: the least delay, {value:.1f} s per vehicle{gain}, and no "
        f"difference between them is shown.{simple}{where}"
    )


def _is_rule(label: str) -> bool:
    entry = CONTROLLERS.get(_name(label))
    return entry is not None and not entry.learns


def _warning(found: Comparison, best: int) -> str:
    count, label = _locks(found, best), _called(found.labels[best])
    return f" But {label} locked in {count} of {len(found.seeds)} seeds." if count else ""


def _locks(found: Comparison, contender: int) -> int:
    """Return in how many seeds a contender locked."""
    return sum(label == found.labels[contender] for label, _ in found.locked)
