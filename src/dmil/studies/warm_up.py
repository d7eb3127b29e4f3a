"""Compile all kernels once, so that workers only load them."""

from __future__ import annotations

from collections.abc import Callable

from dmil.compilation import is_cold, mark_warm
from dmil.studies.block import run_block
from dmil.studies.executors import Executor, LocalExecutor
from dmil.studies.plan import Architecture, Block
from dmil.studies.settings import PaperStudySettings

# The longest first. What the paper mentions beside its own rule has kernels of its own.
PARTS: dict[str, Callable[[Architecture], bool]] = {
    "memory-based": lambda each: each.controller == "dual-memory" and not each.variant,
    "others": lambda each: each.controller != "dual-memory",
    "variants": lambda each: bool(each.variant),
}
"""Parts of a study whose kernels differ most; each is compiled in one process."""


def compile_kernels(executor: Executor | None = None) -> None:
    """Run a miniature of the study if the kernels are not compiled yet (ours).

    Without it every worker process of a first start would compile the same kernels.

    Parameters
    ----------
    executor
        Processes of this machine that do it, if it has some.
    """
    if not is_cold():
        return
    here = executor if isinstance(executor, LocalExecutor) else LocalExecutor()
    for _ in here.map(_compile, list(PARTS)):
        pass
    mark_warm()


def _compile(part: str) -> None:
    # Two agents and 200 s: the smallest run in which the agents meet the central unit.
    settings = PaperStudySettings(grids=("1x2",), seeds=1, horizon_s=200, variant_seeds=1)
    run_block(settings, Block(settings.presets[-1], "grid:1x2", 0), PARTS[part])
