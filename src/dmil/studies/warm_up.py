"""Compile all kernels once, so that workers only load them."""

from __future__ import annotations

from dmil.compilation import is_cold, mark_warm
from dmil.studies.block import run_block
from dmil.studies.plan import Block
from dmil.studies.settings import PaperStudySettings


def compile_kernels() -> None:
    """Run a miniature of the study if the kernels are not compiled yet (ours).

    Without it every worker process of a first start would compile the same kernels.
    """
    if not is_cold():
        return
    # Two agents and 200 s: the smallest run in which the agents meet the central unit.
    settings = PaperStudySettings(grids=("1x2",), seeds=1, horizon_s=200)
    run_block(settings, Block("literal", "grid:1x2", 0))
    mark_warm()
