"""Check of a controller."""

from __future__ import annotations

from collections.abc import Callable

from dmil.controllers import Controller, MemoryController
from dmil.scenarios import Scenario
from dmil.testing.memories import check_memory
from dmil.testing.proving_grounds import proving_grounds
from dmil.testing.trials import ControllerRule, Trial, chance, no_reward


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
            check_memory(trial)


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
