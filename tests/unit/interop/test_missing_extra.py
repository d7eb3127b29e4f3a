"""Without the extra `zoo` there is one clear error, and the rest of the package works."""

import subprocess
import sys

import pytest

BLOCK = """
import sys

class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {missing!r}:
            raise ModuleNotFoundError(f"No module named '{{name}}'", name=name)

sys.meta_path.insert(0, Absent())
import dmil
dmil.scenario("grid:1x1")
try:
    import dmil.interop
    made = dmil.interop.parallel_env("grid:1x1", render_mode="rgb_array")
    made.reset(seed=0)
    made.render()
except dmil.DmilError as error:
    print(error)
"""


@pytest.mark.parametrize("missing", [("gymnasium",), ("pettingzoo",), ("PIL",)])
def test_the_error_names_the_command_that_installs_it(missing):
    code = BLOCK.format(missing=missing)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "pip install 'dmil[zoo]'" in done.stdout
