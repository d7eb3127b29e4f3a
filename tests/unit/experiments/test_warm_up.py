import os
import subprocess
import sys

from dmil.experiments import warm_up
from dmil.experiments.warm_up import compile_kernels
from dmil.parallel import LocalExecutor, RayExecutor

COMPILED = """
import sys
from numba.core import event

class Compiled(event.Listener):
    def on_start(self, event):
        print(event.data["dispatcher"].py_func.__qualname__)

    def on_end(self, event):
        pass

event.register("numba:compile", Compiled())
"""
BLOCK = """
from dmil.studies.paper.block import run_block
from dmil.studies.paper.plan import Block
from dmil.studies.paper.settings import PaperStudySettings

settings = PaperStudySettings(grids=("1x2",), seeds=1, horizon_s=200, variant_seeds=1)
result = run_block(settings, Block(settings.presets[-1], "grid:1x2", 0))
assert {row["status"] for row in result.runs} == {"ok"}
assert any(row["variant"] for row in result.runs)
"""


def test_a_worker_has_nothing_left_to_compile(tmp_path):
    """Cold kernels: a minute of one core; nothing else tells what a first start is like."""

    def run(code: str) -> str:
        environment = os.environ | {"DMIL_CACHE": str(tmp_path)}
        command = [sys.executable, "-c", code]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
        return done.stdout

    warm_up = "from dmil.experiments.warm_up import compile_kernels\n"
    warm_up += "from dmil.parallel import LocalExecutor\n"
    run(warm_up + "compile_kernels(LocalExecutor(1))")
    assert run(COMPILED + BLOCK) == ""


def test_for_runs_elsewhere_this_process_compiles(monkeypatch):
    """A script that runs on Ray needs no guard around its main part for it."""
    used = []
    monkeypatch.setattr(warm_up, "is_cold", lambda: True)
    monkeypatch.setattr(warm_up, "mark_warm", lambda: None)
    monkeypatch.setattr(LocalExecutor, "map", lambda self, *_: used.append(self.jobs) or iter(()))
    compile_kernels(RayExecutor())
    compile_kernels(LocalExecutor(3))
    assert used == [1, 3]
