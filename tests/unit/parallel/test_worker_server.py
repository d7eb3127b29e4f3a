"""The server of worker processes does not hear Ctrl-C."""

import os
import signal
import subprocess
import sys

PROGRAM = """
import os, pathlib, signal, time
from dmil.parallel.worker_server import start_worker_server

# Who starts tests in the background may have them ignore the signal.
signal.signal(signal.SIGINT, signal.default_int_handler)
start_worker_server("slow_to_import")
while not pathlib.Path("begun").exists():
    time.sleep(0.01)
os.killpg(0, signal.SIGINT)
# The signal may take a moment: the program must not be over before.
time.sleep(10)
"""
MODULE = """
import pathlib, time

pathlib.Path("begun").touch()
time.sleep(0.5)
"""


def test_ctrl_c_while_it_imports_is_silent(tmp_path):
    (tmp_path / "slow_to_import.py").write_text(MODULE)
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(tmp_path)},
        timeout=300,
        stderr=subprocess.PIPE,
        text=True,
        check=False,
        start_new_session=True,
    )
    assert done.returncode == -signal.SIGINT
    assert done.stderr.count("Traceback") == 1, done.stderr
