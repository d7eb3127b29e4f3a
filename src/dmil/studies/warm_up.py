"""Compile all kernels once, so that workers only load them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from dmil.compilation import is_cold, mark_warm
from dmil.controllers import Prior, Situation, make_controller
from dmil.controllers.variants import read_options
from dmil.memory import make_value_table
from dmil.seeding import stream
from dmil.simulation import QueueSimulator
from dmil.studies.block import run_block
from dmil.studies.executors import Executor, LocalExecutor
from dmil.studies.plan import VARIANTS, Block
from dmil.studies.settings import PaperStudySettings
from dmil.training import vehicles_of_seed

# Two agents and 200 s: the smallest run in which the agents meet the central unit.
SMALLEST = PaperStudySettings(grids=("1x2",), seeds=1, horizon_s=200, variant_seeds=0)


def compile_kernels(executor: Executor | None = None) -> None:
    """Run a miniature of the study if the kernels are not compiled yet (ours).

    Without it every worker process of a first start would compile the same kernels. Those that the
    memory-based agents alone have, more than half, are compiled beside the others.

    Parameters
    ----------
    executor
        Where the study runs. Processes of this machine do it, one per core by default; for runs
        elsewhere this process does it.
    """
    if not is_cold():
        return
    here = executor or LocalExecutor()
    if not isinstance(here, LocalExecutor):
        here = LocalExecutor(1)
    for _ in here.map(_call, [_decide_from_memory, _run_the_others]):
        pass
    mark_warm()


def _call(part: Callable[[], None]) -> None:
    part()


def _run_the_others() -> None:
    block = Block(SMALLEST.presets[0], "grid:1x2", 0)
    run_block(SMALLEST, block, lambda architecture: architecture.controller != "dual-memory")


def _decide_from_memory() -> None:
    """Let the memory-based agents decide in an empty network: no simulator, and no training."""
    scenario = SMALLEST.recipe("grid:1x2").build()
    empty = QueueSimulator(scenario).reset(vehicles_of_seed(scenario, 0))
    actions = max(len(item.phases) for item in scenario.network.intersections)
    prior = Prior(make_value_table(1, 1, empty.queue_veh.shape[1], actions, tolerance=0))
    for variant in VARIANTS:
        options = SMALLEST.dual_memory.model_dump() | {"communication": True}
        options |= read_options([variant], where="variant")
        controller = make_controller("dual-memory", options, prior=prior)
        chance = stream(0, "exploration")
        controller.begin(Situation(scenario.network, scenario.timing, chance))
        for time_s in range(0, scenario.horizon_s, scenario.timing.decision_interval_s):
            controller.decide(replace(empty, time_s=time_s), np.zeros(empty.phase.size))
