"""Before and around a command's runs: its scenario, the first start's kernels, Ctrl-C."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from dmil.cli.application import StoppedError
from dmil.cli.terminal import say, waiting
from dmil.compilation import is_cold
from dmil.demand.sumo.acting import ACTING
from dmil.demand.sumo.remarks import LEFT_OUT, remarks_of
from dmil.experiments.warm_up import compile_kernels
from dmil.scenarios import Scenario
from dmil.scenarios.recipe import ScenarioRecipe
from dmil.simulation.stand_ins import stand_ins


def built(recipe: ScenarioRecipe) -> Scenario:
    """Make the scenario; say which vehicles are left out, and what does not act on them."""
    made = recipe.build()
    for remark in remarks_of(made.demand):
        if remark.kind in ACTING or remark.kind in LEFT_OUT:
            what = remark.text.partition(";")[0]
            say(f"Warning: {remark.count} {what} (first '{remark.example}').")
    return made


def say_stand_ins(scenario: Scenario, simulator: str, controllers: Iterable[str]) -> None:
    """Say which intersections' own control the queue simulator cannot run."""
    if simulator == "queue" and "program" in controllers:
        for sentence in stand_ins(scenario.network):
            say(f"Warning: {sentence}.")


def compile_first() -> None:
    """Compile all kernels where this has not been done, and say so."""
    if is_cold():
        with waiting("First start: compiling kernels, once …"):
            compile_kernels()


@contextmanager
def stopping(text: str) -> Iterator[None]:
    """Let Ctrl-C end a command with what is kept, and how to go on."""
    try:
        yield
    except KeyboardInterrupt:
        raise StoppedError(text) from None
