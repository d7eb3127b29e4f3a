"""Successive halving: many candidates on few seeds, the better ones on more.

The library is Optuna: its tree-structured Parzen estimator proposes candidates, its pruner decides
who goes on (asynchronous successive halving: Li et al., MLSys 2020). Candidates are asked for, run
and told in rounds of a fixed size, each rung of a round as a whole, so that the search does not
depend on how many run at once.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from dmil.controllers.entry import Choice, Range
from dmil.errors import MissingExtraError
from dmil.experiments.tuning.record import FACTOR, RUNGS
from dmil.experiments.tuning.spaces import Space

AT_ONCE = FACTOR ** (RUNGS - 1)
"""Candidates of a round: in the mean one of them comes to the last rung."""
MOST_REPETITIONS = 100
"""Proposals known already after which a space counts as exhausted."""

State = Literal["finished", "stopped", "repeated", "failed", "no budget"]
Values = dict[str, Any]
Row = tuple[float, ...]
Scores = Callable[[Sequence[Values], range], list[list[float | str]]]
"""Scores of some candidates with the tuning seeds of some places; text where there is none."""


@dataclass
class Candidate:
    """Values for the options of a space.

    Attributes
    ----------
    values: dict
        The options.
    state
        finished: scored with the seeds of the last rung; stopped: others were better; repeated: its
        scores are those of another one, to which it makes no difference; failed: a run failed; no
        budget: nothing was left for its next rung.
    mean: float
        Mean score of the rungs that it has finished, NaN before the first.
    """

    values: Values
    state: State = "no budget"
    mean: float = math.nan


def halve(
    space: Space,
    usual: tuple[Values, list[float]],
    scores: Scores,
    rungs: Sequence[int],
    *,
    budget: int,
    seed: int,
) -> list[Candidate]:
    """Search a space for the lowest mean score (Jamieson and Talwalkar, AISTATS 2016).

    ``usual`` are the values of the defaults, which are no candidate, and their scores with all
    seeds; a rung's seeds include those of earlier rungs; the budget counts scores in all; the seed
    is that of what is proposed.

    Raises
    ------
    MissingExtraError
        Without Optuna.
    """
    study = _new_study(space, usual, seed)
    candidates: list[Candidate] = []
    tried = [usual[0]]
    known: set[Row] = {tuple(usual[1][:seeds]) for seeds in rungs}
    while True:
        fitting = (n for n in range(AT_ONCE, 0, -1) if _cost_of_round(n, rungs) <= budget)
        asked = _ask(study, space, next(fitting, 0), tried)
        if not asked:
            return candidates
        candidates += [candidate for _, candidate in asked]
        budget = _run_round(study, asked, scores, rungs, budget, known)


def _run_round(
    study: Any,
    asked: list[tuple[Any, Candidate]],
    scores: Scores,
    rungs: Sequence[int],
    budget: int,
    known: set[Row],
) -> int:
    """Take candidates up the rungs as far as they come; return what is left of the budget."""
    state = _optuna().trial.TrialState
    found: dict[int, list[float | str]] = {trial.number: [] for trial, _ in asked}
    going = asked
    for rung, seeds in enumerate(rungs):
        places = range(rungs[rung - 1] if rung else 0, seeds)
        ranked = sorted(going, key=lambda each: (each[1].mean, each[0].number)) if rung else going
        paid = {trial.number for trial, _ in ranked[: budget // len(places)]}
        for trial, _ in going:
            if trial.number not in paid:
                study.tell(trial, state=state.PRUNED)
        going = [each for each in going if each[0].number in paid]
        budget -= len(going) * len(places)
        rows = scores([candidate.values for _, candidate in going], places)
        promoted = []
        for (trial, candidate), row in zip(going, rows, strict=True):
            found[trial.number] += row
            numbers = [each for each in found[trial.number] if not isinstance(each, str)]
            if len(numbers) < len(found[trial.number]):
                candidate.state = "failed"
                study.tell(trial, state=state.FAIL)
                continue
            candidate.mean = float(np.mean(numbers))
            if seeds == rungs[-1]:
                candidate.state = "finished"
                study.tell(trial, candidate.mean)
                continue
            trial.report(candidate.mean, step=FACTOR**rung)
            repeated = tuple(numbers) in known
            known.add(tuple(numbers))
            if trial.should_prune() or repeated:
                candidate.state = "repeated" if repeated else "stopped"
                study.tell(trial, state=state.PRUNED)
            else:
                promoted.append((trial, candidate))
        going = promoted
    return budget


def _ask(study: Any, space: Space, count: int, tried: list[Values]) -> list[tuple[Any, Candidate]]:
    """Return new candidates, fewer than asked for where the space has no more."""
    fail = _optuna().trial.TrialState.FAIL
    distributions = _distributions(space)
    asked: list[tuple[Any, Candidate]] = []
    repeated = 0
    while len(asked) < count and repeated < MOST_REPETITIONS:
        trial = study.ask(distributions)
        values = {name: _rounded(space[name], value) for name, value in trial.params.items()}
        if values in tried:
            study.tell(trial, state=fail)
            repeated += 1
            continue
        tried.append(values)
        asked.append((trial, Candidate(values)))
        repeated = 0
    return asked


def _cost_of_round(count: int, rungs: Sequence[int]) -> int:
    """Return the scores of a round in which every rung keeps its share."""
    cost, before = 0, 0
    for rung, seeds in enumerate(rungs):
        cost += math.ceil(count / FACTOR**rung) * (seeds - before)
        before = seeds
    return cost


def _new_study(space: Space, usual: tuple[Values, list[float]], seed: int) -> Any:
    optuna = _optuna()
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    study = optuna.create_study(
        sampler=optuna.samplers.TPESampler(seed=seed),
        pruner=optuna.pruners.SuccessiveHalvingPruner(min_resource=1, reduction_factor=FACTOR),
    )
    values, scores = usual
    if all(_inside(space[name], values[name]) for name in space):
        study.add_trial(
            optuna.trial.create_trial(
                params=values, distributions=_distributions(space), value=float(np.mean(scores))
            )
        )
    return study


def _distributions(space: Space) -> dict[str, Any]:
    known = _optuna().distributions
    return {
        name: known.CategoricalDistribution(each.values)
        if isinstance(each, Choice)
        else known.IntDistribution(int(each.low), int(each.high), log=each.log)
        if each.whole
        else known.FloatDistribution(each.low, each.high, log=each.log)
        for name, each in space.items()
    }


def _inside(values: Range | Choice, value: Any) -> bool:
    if isinstance(values, Choice):
        return value in values.values
    return isinstance(value, int | float) and values.low <= value <= values.high


def _rounded(values: Range | Choice, value: Any) -> Any:
    return value if isinstance(values, Choice) else values.rounded(value)


def library_version() -> str:
    """Return which version of Optuna proposes candidates; a `MissingExtraError` without."""
    return f"optuna {_optuna().__version__}"


def _optuna() -> Any:
    try:
        import optuna
    except ImportError:
        raise MissingExtraError("tune") from None
    return optuna
