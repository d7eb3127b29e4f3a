"""Check of a controller, and of its memory."""

from __future__ import annotations

import copy
import io
import math
from collections.abc import Callable, Mapping
from dataclasses import asdict
from functools import partial

import numpy as np

from dmil.controllers import Controller, MemoryController, MemoryUse
from dmil.scenarios import Scenario
from dmil.testing.conformance import array_in_words
from dmil.testing.proving_grounds import proving_grounds
from dmil.testing.trials import ControllerRule, Trial, chance, no_reward

RESERVED = ("file", "header")
"""Names that a policy file needs for itself."""


def check_controller(make: Callable[[], object], scenario: Scenario | None = None) -> None:
    """Check a controller on networks of different shapes.

    What its choices are worth is not judged.

    Parameters
    ----------
    make
        Makes a new controller, such as its class.
    scenario
        Where to check it instead, for one that is made for a network of its own.

    Raises
    ------
    ConformanceError
        At the first rule that is broken, see `ControllerRule`.
    """
    for ground in proving_grounds() if scenario is None else (scenario,):
        trial = Trial(make, ground)
        controller = trial.make()
        _check_chance(trial, controller)
        if isinstance(controller, MemoryController):
            _check_memory(trial)


def _check_chance(trial: Trial, first: Controller) -> None:
    second = trial.make()
    trial.witness.expect(
        first is not second,
        ControllerRule.FRESH,
        "the same object twice",
        "a new controller, such as from its class or from lambda: MyController(option)",
    )
    rng = chance("first run")
    chosen = trial.run(first, "the first run", rng)
    again = trial.run(second, "the first run of a second controller", chance("first run"))
    trial.expect_same_phases(
        chosen, again, ControllerRule.REPEAT, "an equal run of a controller made before"
    )
    drawn = rng.bit_generator.state
    trial.run(first, "the second run, where all rewards are 0,", chance("second run"), no_reward)
    trial.witness.expect(
        rng.bit_generator.state == drawn,
        ControllerRule.CHANCE,
        "it drew from the generator of an earlier run",
        "draws from the generator that reset was given last",
    )


def _check_memory(trial: Trial) -> None:
    """Check a controller that remembers: measured, saved, restored."""
    learner = _remembering(trial)
    _run(trial, learner, "the first run", "memory")
    arrays = _checked_arrays(trial, learner)
    kept, loaded = copy.deepcopy(arrays), _through_a_file(trial, arrays)
    given = copy.deepcopy(loaded)
    restored = _remembering(trial)
    with trial.witness.no_exception(ControllerRule.RESTORE, "restore after reset"):
        restored.reset(trial.context(chance("restore")))
        restored.restore(loaded)
        use = restored.memory_use()
    _expect_same_entries(trial, learner.memory_use(), use)
    old = _run(trial, learner, "the second run", "restored")
    new = _run(trial, restored, "the first run after restore", "restored")
    trial.expect_same_phases(
        old, new, ControllerRule.RESTORE, "the controller whose arrays were restored"
    )
    copies = "copies, so that a saved policy stays what it was"
    for before, after, what in ((kept, arrays, "arrays() gave"), (given, loaded, "restore took")):
        found = f"what {what} was changed: {{}}"
        trial.witness.expect_same(ControllerRule.SNAPSHOT, before, after, "arrays", found, copies)


def _remembering(trial: Trial) -> MemoryController:
    made = trial.make()
    assert isinstance(made, MemoryController)
    return made


def _run(trial: Trial, controller: MemoryController, label: str, rng: str) -> list[np.ndarray]:
    check = partial(_check_use, trial, controller)
    return trial.run(controller, label, chance(rng), after_decision=check)


def _check_use(trial: Trial, controller: MemoryController) -> None:
    rule, expect = ControllerRule.MEMORY_USE, trial.witness.expect
    with trial.witness.no_exception(rule, "memory_use"):
        use: object = controller.memory_use()
    if not isinstance(use, MemoryUse):
        trial.witness.fail(rule, f"a {type(use).__name__}", "a dmil.controllers.MemoryUse")
    for name, value in asdict(use).items():
        number = isinstance(value, int | float | np.number)
        counts = number and math.isfinite(value) and value >= 0
        expect(counts, rule, f"{name} = {value!r}", "a number of 0 or more")
    agents = len(trial.network.intersections)
    # A shared entry counts for every agent that has it, but once in the total.
    least, most = use.entries * (1 - 1e-9), use.entries * agents * (1 + 1e-9)
    expect(
        least <= use.entries_total <= most,
        rule,
        f"{use.entries_total} entries in total, and {use.entries:g} per agent for {agents} agents",
        f"a total from {use.entries:g} (all shared) to {use.entries * agents:g} (none shared)",
    )
    expect(
        use.bytes_total > 0 or use.entries_total == 0,
        rule,
        f"{use.entries_total} entries in {use.bytes_total} bytes",
        "bytes above 0",
    )


def _checked_arrays(trial: Trial, learner: MemoryController) -> dict[str, np.ndarray]:
    trial.witness.where = f"after the first run on {trial.name}"
    rule, expect, same = ControllerRule.ARRAYS, trial.witness.expect, trial.witness.expect_same
    with trial.witness.no_exception(rule, "arrays"):
        use, given = learner.memory_use(), learner.arrays()
        use_again, given_again = learner.memory_use(), learner.arrays()
    same(ControllerRule.MEMORY_USE, use, use_again, "memory_use()")
    named = "a dict of names and numpy arrays"
    expect(isinstance(given, Mapping), rule, f"a {type(given).__name__}", named)
    arrays = dict(given)
    for name, value in arrays.items():
        expect(
            isinstance(name, str) and name not in RESERVED,
            rule,
            f"the name {name!r}",
            f"names that are strings other than {' and '.join(RESERVED)}",
        )
        expect(
            isinstance(value, np.ndarray) and not value.dtype.hasobject,
            rule,
            f"{name!r} is {array_in_words(value)}",
            "a numpy array of numbers, without Python objects in it",
        )
    same(rule, arrays, dict(given_again), "arrays()")
    return arrays


def _through_a_file(trial: Trial, arrays: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    file = io.BytesIO()
    with trial.witness.no_exception(ControllerRule.ARRAYS, "numpy.savez on arrays()"):
        np.savez(file, allow_pickle=False, **arrays)
        file.seek(0)
        with np.load(file, allow_pickle=False) as loaded:
            return {name: loaded[name] for name in loaded.files}


def _expect_same_entries(trial: Trial, old: MemoryUse, new: MemoryUse) -> None:
    trial.witness.where = f"after restore on {trial.name}"
    for name in ("short_term_entries", "long_term_entries", "table_entries", "entries_total"):
        trial.witness.expect(
            getattr(old, name) == getattr(new, name),
            ControllerRule.RESTORE,
            f"{name} = {getattr(new, name)}",
            f"{getattr(old, name)}, as in the controller whose arrays were restored",
        )
