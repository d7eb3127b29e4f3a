"""How a policy compares, shown after training, so that a losing agent is not recommended."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from dmil.cli.terminal import number
from dmil.controllers import RECOMMENDED
from dmil.controllers.variants import parse_variant
from dmil.experiments.answer import METRIC
from dmil.experiments.comparison import Comparison, compare, has_same_demand
from dmil.experiments.contender import Contender
from dmil.parallel import LocalExecutor
from dmil.scenarios import Scenario
from dmil.scenarios.recipe import ScenarioRecipe
from dmil.training import Policy

RIVALS = ("max-pressure", "longest-queue-first,approaching=true", RECOMMENDED)
"""What a policy should beat: none of them needs a training."""
SEEDS = 3


def judged(path: Path, policy: Policy, recipe: ScenarioRecipe, scenario: Scenario) -> Comparison:
    """Run a policy, frozen, beside the network's plan and rivals in the queue simulator."""
    plan = all(item.program for item in scenario.network.intersections)
    rivals = ("program" if plan else "fixed-cycle", *RIVALS)
    contenders = [Contender.trained(path, policy, {})]
    contenders += [Contender(text, parse_variant(text)) for text in rivals]
    seeds = range(1 if has_same_demand(scenario, 0) else SEEDS)
    return compare(recipe, contenders, seeds, executor=LocalExecutor(1)).ranked(METRIC)


def verdict(found: Comparison, path: Path) -> list[str]:
    """Say how it compares, in lines."""
    means = found.measures[METRIC].mean(axis=0).tolist()
    own = found.labels.index(path.name)
    better = [label for label, mean in zip(found.labels, means, strict=True) if mean < means[own]]
    runs = f"mean of {len(found.seeds)} runs" if len(found.seeds) > 1 else "one run"
    if means[own] != means[own]:
        said = "No vehicle departed, so nothing is compared."
    elif better:
        said = (
            f"{path.name} loses to {better[0]}, which needs no training, by "
            f"{number(means[own] - means[0], 1)} s per vehicle."
        )
    else:
        said = f"{path.name} has the lowest delay."
    width = max(map(len, found.labels))
    return [
        f"Frozen, against controllers that need no training: delay in s, {runs} in the queue "
        "simulator:",
        *(
            f"  {label:{width}}  {number(mean, 1):>8}"
            for label, mean in zip(found.labels, means, strict=True)
        ),
        said,
        *(f"  {path.name} locked in {n} of {len(found.seeds)} runs." for n in _locked(found, path)),
    ]


def as_json(found: Comparison) -> dict[str, Any]:
    """Return the mean delays in s by contender."""
    means = found.measures[METRIC].mean(axis=0).tolist()
    return {METRIC: dict(zip(found.labels, means, strict=True)), "seeds": list(found.seeds)}


def _locked(found: Comparison, path: Path) -> list[int]:
    count = sum(label == path.name for label, _ in found.locked)
    return [count] if count else []
