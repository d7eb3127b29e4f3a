"""How much a tuning spends, and what it found, as a file that people can read, too."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from dmil.controllers import CONTROLLERS, check_controller, make_settings
from dmil.controllers.variants import Variant
from dmil.errors import InputError
from dmil.files import write_text_atomically
from dmil.importing import check_trusted
from dmil.rewards import PAPER_CONSTANTS, RewardConstants
from dmil.seeding import LARGEST_SEED, stream
from dmil.statistics import Estimate, paired_difference

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


FORMAT = "dmil-tuned"
FORMAT_VERSION = 1
ENDING = ".json"
ENDS = {"mean": "value", "low": "low", "high": "high"}

Score = float | str | None


class TrialRecord(BaseModel):
    """What one candidate got."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    values: dict[str, Any] = Field(description="Its options; none for the defaults.")
    state: str = Field("unfinished", description="Status.")
    mean: float | None = Field(None, description="Mean score of the rungs that it finished.")
    scores: tuple[Score, ...] = Field(
        description="Score with each tuning seed, those of the check last; none where it was not "
        "run, text where the run failed."
    )


class Tuned(BaseModel):
    """What was tuned, how, and what came out."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    dmil: str = Field(description="Version of the program.")
    controller: str = Field(description="Name of the controller.")
    fixed: dict[str, Any] = Field(description="Options that were set and not tuned.")
    chosen: dict[str, Any] = Field({}, description="Options to use, fixed ones included.")
    scenario: str = Field(description="Name of the scenario.")
    recipe: dict[str, Any] = Field(description="The scenario, as for a policy.")
    same_demand: bool = Field(description="Whether its vehicles are the same in every seed.")
    simulator: str = Field(description="Simulator of all runs.")
    reward: str = Field(description="What it got if it learns.")
    reward_constants: RewardConstants = Field(
        PAPER_CONSTANTS, description="Constants of that reward."
    )
    horizon_s: int = Field(description="Length of a run in s.")
    settings: dict[str, Any] = Field(description="Budget, seeds, and what was made low.")
    space: dict[str, Any] = Field(description="Values that were searched.")
    library: str = Field("", description="Library that proposed candidates.")
    finished: bool = Field(False, description="Whether the tuning came to its end.")
    runs: int = Field(0, ge=0, description="Runs that were spent.")
    trials: tuple[TrialRecord, ...] = Field((), description="The defaults, then all candidates.")
    best: int = Field(0, ge=0, description="Which trial was chosen; 0: the defaults.")

    @property
    def label(self) -> str:
        """The controller with its fixed options, in one word."""
        return Variant(self.controller, self.fixed).label

    @property
    def cell(self) -> str:
        """Scenario with its load, as in ``grid:3x3*2``."""
        load = self.recipe.get("load", 1.0)
        return self.scenario if load == 1.0 else f"{self.scenario}*{load:g}"

    @property
    def simulated_s(self) -> int:
        """Simulated time that was spent, in s."""
        return self.runs * self.horizon_s

    @property
    def leader(self) -> int:
        """The trial that the check compares with the defaults: the best of the search."""
        finished = [i for i, each in enumerate(self.trials) if each.state == "finished"]
        return min(finished, key=lambda i: (self.trials[i].mean, i), default=0)

    def check(self, trial: int) -> np.ndarray:
        """Return the (check seeds,) scores of a trial, NaN where there is none."""
        scores = self.trials[trial].scores[self.settings["seeds"] :]
        return np.array([each if isinstance(each, float) else np.nan for each in scores])

    @property
    def rungs(self) -> list[tuple[int, int]]:
        """Seeds of each rung, and how many candidates were run on them, the defaults left out."""
        seeds = TuningSettings(**self.settings).rungs
        return [
            (count, sum(each.scores[count - 1] is not None for each in self.trials[1:]))
            for count in seeds
        ]

    def summary(self) -> dict[str, Any]:
        """Return what a report tells: budget, chosen values, best against defaults."""
        checked = self.leader > 0
        return {
            "controller": self.label,
            "scenario": self.cell,
            "metric": self.settings["metric"],
            "reward": self.reward,
            "episodes": self.settings["episodes"],
            "budget_runs": self.settings["budget"] if self.space else 0,
            "runs": self.runs,
            "simulated_s": self.simulated_s,
            "rungs": [{"seeds": seeds, "candidates": count} for seeds, count in self.rungs],
            "failed": sum(each.state == "failed" for each in self.trials),
            "tuned_options": list(self.space),
            "chosen": self.chosen,
            "defaults_kept": self.best == 0,
            "check_seeds": self.settings["check_seeds"] if checked else 0,
            "default_mean": float(self.check(0).mean()) if checked else self._search_mean(0),
            "best_mean": float(self.check(self.leader).mean()) if checked else None,
            "best_minus_default": self._ends(relative=False) if checked else None,
            "best_over_default_minus_1": self._ends(relative=True) if checked else None,
            "same_demand": self.same_demand,
        }

    def _ends(self, *, relative: bool) -> dict[str, float]:
        found = self.difference(relative=relative)
        return {name: float(getattr(found, field)[0]) for name, field in ENDS.items()}

    def _search_mean(self, trial: int) -> float | None:
        return self.trials[trial].mean if self.trials else None

    def difference(self, *, relative: bool) -> Estimate:
        """Return leader minus defaults on the check's seeds, with its paired interval.

        Parameters
        ----------
        relative
            As a part of the defaults' mean.
        """
        rng = stream(0, "bootstrap", "tuning")
        leader, usual = (self.check(trial)[:, None] for trial in (self.leader, 0))
        return paired_difference(leader, usual, rng, relative=relative)


def save_tuned(tuned: Tuned, path: Path) -> None:
    """Write a tuning, finished or not; an `OutputError` if the file cannot be written."""
    head = {"format": FORMAT, "version": FORMAT_VERSION}
    body = tuned.model_dump(mode="json")
    trials = body.pop("trials")
    # A trial a line: a file of hundreds stays readable.
    lines = [f"    {json.dumps(each)}" for each in trials]
    text = json.dumps(head | body, indent=2).removesuffix("\n}")
    joined = ",\n".join(lines)
    write_text_atomically(path, f'{text},\n  "trials": [\n{joined}\n  ]\n}}\n')


def load_tuned(path: Path) -> Tuned:
    """Read a tuning that came to its end. Reading runs no code of the file's.

    Raises
    ------
    InputError
        The file is missing, damaged, of another version, unfinished, its options do not exist, or
        it names a part by an import path that is not trusted, see `dmil.trust`.
    """
    tuned = read_tuned(path)
    where = str(path)
    if not tuned.finished:
        raise InputError(
            "this tuning did not come to its end",
            where=where,
            mend="give the same dmil tune command again: it goes on",
        )
    check_trusted(tuned.controller, "controller", where=where)
    check_trusted(tuned.reward, "reward", where=where)
    check_trusted(tuned.chosen.get("embedding"), "embedding", where=where)
    check_controller(tuned.controller, where=where)
    entry = CONTROLLERS.get(tuned.controller)
    settings = entry.settings if entry else None
    if settings is not None:
        make_settings(settings, tuned.chosen, where=f"{where}: controller '{tuned.controller}'")
    # Who has no option to tune has no trials.
    values = [each.values for each in tuned.trials] or [{}]
    if tuned.best >= len(values) or tuned.chosen != tuned.fixed | values[tuned.best]:
        raise InputError(
            "damaged: what is chosen is not its best trial",
            where=where,
            expected="a file as dmil tune wrote it",
            mend="tune again",
        )
    return tuned


def load_tuned_folder(folder: Path) -> list[Tuned]:
    """Read every tuning in a folder.

    Raises
    ------
    InputError
        There is no such folder, no tuning in it, or one that `load_tuned` refuses.
    """
    found = [load_tuned(path) for path in sorted(folder.glob(f"*{ENDING}"))]
    if not found:
        raise InputError(
            "no tuned controller is there",
            where=str(folder),
            expected="the --out folder of dmil tune",
        )
    return found


def read_tuned(path: Path) -> Tuned:
    """Read a tuning, finished or not; an `InputError` if damaged or of another version."""
    where = str(path)
    expected = "a file that dmil tune wrote"
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(
            "there is no such file", where=where, mend="make one with: dmil tune --out FOLDER"
        ) from None
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror})", where=where) from None
    except ValueError as error:
        raise InputError(f"damaged: {error}", where=where, expected=expected) from None
    if not isinstance(found, dict) or found.pop("format", None) != FORMAT:
        raise InputError("no tuned controller", where=where, expected=expected)
    version = found.pop("version", None)
    if version != FORMAT_VERSION:
        raise InputError(
            f"version {version} of the format, written by dmil {found.get('dmil')}",
            where=where,
            expected=f"version {FORMAT_VERSION}",
            mend="tune again with this version of dmil",
        )
    try:
        return _checked(Tuned(**found))
    except (ValidationError, KeyError, TypeError) as error:
        raise InputError(f"damaged: {_first(error)}", where=where, expected=expected) from None


def _checked(tuned: Tuned) -> Tuned:
    places = tuned.settings["seeds"] + tuned.settings["check_seeds"]
    for each in tuned.trials:
        if len(each.scores) != places:
            raise TypeError(f"a trial has {len(each.scores)} scores in place of {places}")
    return tuned


def _first(error: Exception) -> str:
    if not isinstance(error, ValidationError):
        return str(error)
    first: Mapping[str, Any] = error.errors()[0]
    return f"{'.'.join(map(str, first['loc']))}: {first['msg']}"
