"""Tune one controller: score the defaults, search, check the best on further seeds, keep all."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from dmil.controllers import CONTROLLERS, make_controller
from dmil.controllers.variants import Variant
from dmil.errors import InputError, OutputError
from dmil.experiments.comparison import CALLS, has_same_demand
from dmil.experiments.study import Progress, run_trials
from dmil.experiments.tuning.halving import Candidate, Values, halve, library_version
from dmil.experiments.tuning.record import (
    Score,
    TrialRecord,
    Tuned,
    TuningSettings,
    read_tuned,
    save_tuned,
)
from dmil.experiments.tuning.scoring import Judge, TuningTrial
from dmil.experiments.tuning.spaces import as_json, defaults, search_space
from dmil.files import held
from dmil.parallel import Executor
from dmil.rewards import PAPER_CONSTANTS, RewardConstants, make_reward
from dmil.scenarios.recipe import ScenarioRecipe
from dmil.seeding import simulator_seed, tuning_seeds
from dmil.simulation import make_simulator
from dmil.version import __version__

SAVE_AFTER_S = 5.0
"""Longest time that a score stays in memory only."""
OUTCOME = {"chosen", "finished", "runs", "trials", "best"}
"""Fields of a tuning that tell what came out; the others tell what it is."""


def tune(
    about: Tuned,
    path: Path,
    *,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Tuned:
    """Tune a controller and keep all that was run in a file; what a file holds is not run again.

    The best of the search is best on the seeds it was chosen with, so it meets the defaults once
    more on further tuning seeds, and is chosen only if it is better there, too.

    Parameters
    ----------
    about
        What is tuned, and how, see `planned_tuning`.
    path
        The file.
    executor
        Where runs happen; the same results with every one.
    progress
        Called with the number of runs done and of those that may be.

    Raises
    ------
    InputError
        A run with the defaults failed.
    OutputError
        The file holds another tuning, another process is at work on it, or it cannot be written.
    """
    with held(path.with_name(f"{path.name}.in-use"), where=path, work="tuning"):
        ledger = _Ledger(about, path)
        if not about.space:
            return ledger.finish(about.model_copy(update={"finished": True, "chosen": about.fixed}))
        if ledger.found is not None and ledger.found.finished:
            return ledger.found
        return _run(about, ledger, executor, progress)


def check_tuning(about: Tuned, path: Path) -> None:
    """Check that a tuning can go into a file.

    Raises
    ------
    OutputError
        The file holds another tuning, or there can be none.
    """
    _Ledger(about, path)


def _run(
    about: Tuned, ledger: _Ledger, executor: Executor | None, progress: Progress | None
) -> Tuned:
    """Run what the ledger does not hold yet, and keep it all."""
    settings = TuningSettings(**about.settings)
    seeds = tuning_seeds(settings.seed, settings.seeds + settings.check_seeds)
    judge = Judge(about, next(CALLS))
    cost = settings.runs_per_seed(learns=CONTROLLERS[about.controller].learns)

    def tell(done: int, total: int) -> None:
        if progress:
            progress(min(ledger.count * cost, settings.budget), settings.budget)

    def scores(candidates: Sequence[Values], places: range) -> list[list[float | str]]:
        plan = [
            [TuningTrial(variant, place, seeds[place]) for place in places]
            for variant in (Variant(about.controller, about.fixed | each) for each in candidates)
        ]
        trials = [trial for row in plan for trial in row]
        run_trials(trials, ledger, lambda _: judge, executor=executor, progress=tell)
        return [[ledger.have(trial) for trial in row] for row in plan]

    try:
        return ledger.finish(_searched(about, settings, scores, ledger, cost))
    finally:
        ledger.save()


def _searched(
    about: Tuned, settings: TuningSettings, scores: Any, ledger: _Ledger, cost: int
) -> Tuned:
    """Run everything and return the finished tuning."""
    search, check = range(settings.seeds), range(settings.seeds, ledger.places)
    first: list[float] = []
    for each in scores([{}], search)[0]:
        if isinstance(each, str):
            raise InputError(
                f"a run with the defaults failed ({each})", where=f"tuning of '{about.label}'"
            )
        first.append(each)
    space = search_space(about.controller, about.fixed)
    candidates = halve(
        space,
        (defaults(about.controller, space), first),
        scores,
        settings.rungs,
        budget=settings.budget // cost - settings.seeds - 2 * settings.check_seeds,
        seed=simulator_seed(settings.seed, "tuning", about.label),
    )
    tried = [Candidate({}, "finished", float(np.mean(first))), *candidates]
    tuned = about.model_copy(update={"trials": ledger.records(tried)})
    leader = tuned.leader
    if leader:
        scores([{}, tried[leader].values], check)
        tuned = about.model_copy(update={"trials": ledger.records(tried)})
    better = leader and np.mean(tuned.check(leader)) < np.mean(tuned.check(0))
    best = leader if better else 0
    return tuned.model_copy(
        update={
            "finished": True,
            "best": best,
            "chosen": about.fixed | tried[best].values,
            "runs": ledger.count * cost,
        }
    )


def planned_tuning(
    recipe: ScenarioRecipe,
    variant: Variant,
    settings: TuningSettings,
    *,
    simulator: str = "queue",
    reward: str = "diffusion",
    reward_constants: RewardConstants = PAPER_CONSTANTS,
) -> Tuned:
    """Return what a tuning is, before anything has run; all that can be wrong with it shows here.

    Parameters
    ----------
    recipe
        Where.
    variant
        Who; its options are fixed.
    settings
        How much, and what for.
    simulator, reward, reward_constants
        See `dmil.simulation.make_simulator` and `dmil.rewards.make_reward`.

    Raises
    ------
    InputError
        There is no such controller, option, scenario or reward, or the budget is too small.
    MissingExtraError
        Without Optuna, or what the controller needs.
    """
    scenario = recipe.build()
    make_reward(reward, reward_constants)
    make_simulator(scenario, simulator)
    make_controller(variant.name, variant.options)
    space = search_space(variant.name, variant.options)
    if space:
        learns = CONTROLLERS[variant.name].learns
        least = settings.least_budget(learns=learns)
        if settings.budget < least:
            raise InputError(
                f"a budget of {settings.budget} runs",
                where=f"tuning of '{variant.label}'",
                expected=f"at least {least}: a score costs "
                f"{settings.runs_per_seed(learns=learns)} runs, training included",
                mend="give more runs, or fewer seeds or episodes",
            )
    return Tuned(
        controller=variant.name,
        fixed=dict(variant.options),
        scenario=scenario.name,
        recipe=recipe.model_dump(mode="json", exclude_none=True),
        same_demand=has_same_demand(scenario, 0),
        simulator=simulator,
        reward=reward,
        reward_constants=reward_constants,
        horizon_s=scenario.horizon_s,
        settings=settings.model_dump(mode="json"),
        space=json.loads(json.dumps(as_json(space))),
        library=library_version() if space else "",
        dmil=__version__,
    )


def _key(options: Mapping[str, Any]) -> str:
    return json.dumps(options, sort_keys=True)


class _Ledger:
    """All scores of one tuning, in its file and in memory."""

    def __init__(self, about: Tuned, path: Path) -> None:
        self._about, self._path = about, path
        self.places = about.settings["seeds"] + about.settings["check_seeds"]
        self._rows: dict[str, list[Score]] = {}
        self._saved_at = time.monotonic()
        self._changed = False
        self.found = self._earlier()

    @property
    def count(self) -> int:
        """How many scores there are."""
        return sum(each is not None for row in self._rows.values() for each in row)

    def left(self, plan: Sequence[TuningTrial]) -> list[TuningTrial]:
        """Return the trials that have no score yet."""
        rows = [self._rows.get(_key(each.variant.options)) for each in plan]
        return [
            each
            for each, row in zip(plan, rows, strict=True)
            if row is None or row[each.place] is None
        ]

    def have(self, trial: TuningTrial) -> float | str:
        """Return a score that is there."""
        score = self._rows[_key(trial.variant.options)][trial.place]
        assert score is not None
        return score

    def keep(self, result: tuple[TuningTrial, float | str]) -> None:
        """Note a score; it is on disk within some seconds."""
        trial, score = result
        row = self._rows.setdefault(_key(trial.variant.options), [None] * self.places)
        row[trial.place] = score
        self._changed = True
        if time.monotonic() - self._saved_at > SAVE_AFTER_S:
            self.save()

    def records(self, candidates: Sequence[Candidate]) -> tuple[TrialRecord, ...]:
        """Return what is known of some candidates."""
        empty: list[Score] = [None] * self.places
        return tuple(
            TrialRecord(
                values=each.values,
                state=each.state,
                mean=None if np.isnan(each.mean) else round(each.mean, 6),
                scores=tuple(self._rows.get(_key(self._about.fixed | each.values), empty)),
            )
            for each in candidates
        )

    def finish(self, tuned: Tuned) -> Tuned:
        """Write the finished tuning."""
        self._changed = False
        save_tuned(tuned, self._path)
        return tuned

    def save(self) -> None:
        """Write what is there so far."""
        if not self._changed:
            return
        self._changed, self._saved_at = False, time.monotonic()
        trials = tuple(
            TrialRecord(values=self._own(options), scores=tuple(row))
            for options, row in self._rows.items()
        )
        save_tuned(self._about.model_copy(update={"trials": trials}), self._path)

    def _own(self, options: str) -> Values:
        fixed = self._about.fixed
        return {name: value for name, value in json.loads(options).items() if name not in fixed}

    def _earlier(self) -> Tuned | None:
        if not self._path.exists():
            above = next(each for each in self._path.parents if each.exists())
            if not above.is_dir():
                raise OutputError("it is no folder", where=str(above), mend="choose another --out")
            return None
        found = read_tuned(self._path)
        different = [
            name
            for name in type(found).model_fields.keys() - OUTCOME
            if getattr(found, name) != getattr(self._about, name)
        ]
        if different:
            raise OutputError(
                f"it holds another tuning, with other {', '.join(sorted(different))}",
                where=str(self._path),
                mend="choose another --out, or give the same options to go on with that tuning",
            )
        for each in found.trials:
            self._rows[_key(found.fixed | each.values)] = list(each.scores)
        return found
