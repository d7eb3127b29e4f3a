import subprocess
import sys

from dmil.experiments import warm_up
from dmil.experiments.warm_up import compile_kernels
from dmil.parallel import LocalExecutor, RayExecutor

WARM_UP_AND_BLOCK = """
import gc

from dmil.compilation import Kernel
from dmil.experiments import warm_up


def called():
    return {
        f"{each.__module__} {each.__qualname__} {types}"
        for each in gc.get_objects()
        if isinstance(each, Kernel)
        for types in each._from_python.signatures
    }


warm_up._decide_from_memory()
warm_up._run_the_others()
before = called()
from dmil.studies.paper.study import run_block
from dmil.studies.paper.plan import Block
from dmil.studies.paper.settings import PaperStudySettings

used = set()
asked = {name: getattr(Kernel, name) for name in ("__call__", "compiled_for")}
for name, function in asked.items():

    def noted(self, *arguments, function=function):
        used.add(self.__qualname__)
        return function(self, *arguments)

    setattr(Kernel, name, noted)
settings = PaperStudySettings(grids=("1x2",), seeds=1, horizon_s=200, variant_seeds=1)
result = run_block(settings, Block(settings.presets[-1], "grid:1x2", 0))
assert {row["status"] for row in result.runs} == {"ok"}
assert any(row["variant"] for row in result.runs)
print(len(used), sorted(called() - before))
"""


def test_a_worker_has_nothing_left_to_compile():
    """What a block calls has been called before, with the same types."""
    command = [sys.executable, "-c", WARM_UP_AND_BLOCK]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    count, new = done.stdout.split(maxsplit=1)
    assert int(count) > 10, done.stdout
    assert new.strip() == "[]"


def test_for_runs_elsewhere_this_process_compiles(monkeypatch):
    """A script that runs on Ray needs no guard around its main part for it."""
    used = []
    monkeypatch.setattr(warm_up, "is_cold", lambda: True)
    monkeypatch.setattr(warm_up, "mark_warm", lambda: None)
    monkeypatch.setattr(LocalExecutor, "map", lambda self, *_: used.append(self.jobs) or iter(()))
    compile_kernels(RayExecutor())
    compile_kernels(LocalExecutor(3))
    assert used == [1, 3]
