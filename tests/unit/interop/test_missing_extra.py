"""Without the extra `zoo` there is one clear error, and the rest of the package works."""

import subprocess
import sys

MISSING = "gymnasium", "pettingzoo", "PIL"
BLOCK = f"""
import sys

class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] == self.missing:
            raise ModuleNotFoundError(f"No module named '{{name}}'", name=name)

absent = Absent()
sys.meta_path.insert(0, absent)
for absent.missing in {MISSING}:
    # What is there stays imported; what is missing, and what would have imported it, is not.
    for name in list(sys.modules):
        if name.split(".")[0] == absent.missing or name.startswith("dmil.interop"):
            del sys.modules[name]
    import dmil
    dmil.scenario("grid:1x1")
    try:
        import dmil.interop
        made = dmil.interop.parallel_env("grid:1x1", render_mode="rgb_array")
        made.reset(seed=0)
        made.render()
    except dmil.DmilError as error:
        print(absent.missing, str(error).replace("\\n", " "))
"""


def test_the_error_names_the_command_that_installs_it():
    command = [sys.executable, "-c", BLOCK]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert [line.split()[0] for line in lines] == list(MISSING)
    assert all("pip install 'dmil[zoo]'" in line for line in lines), lines
