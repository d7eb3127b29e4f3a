"""The process that SUMO runs in, from the side of the simulator."""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
import weakref
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, NoReturn

from dmil.errors import MissingExtraError, SimulationError

LAST_LINES = 5
"""How many lines of SUMO's complaint an error shows."""
PATIENCE_S = 5.0
"""How long a process may take to end by itself."""


class SumoProcess:
    """A running `dmil.simulation.sumo.worker` and the folder of its files; both end with this.

    Parameters
    ----------
    where
        What errors say it simulates.

    Raises
    ------
    MissingExtraError
        If libsumo is not installed.
    """

    def __init__(self, where: str) -> None:
        require_sumo()
        self._where = where
        self.folder = Path(tempfile.mkdtemp(prefix="dmil-sumo-"))
        self._messages = self.folder / "messages.txt"
        self._connection, theirs = Pipe()
        environment = dict(os.environ)
        if importlib.util.find_spec("sumo"):
            # libsumo then takes the folder of the installed package, not that of another SUMO.
            environment.pop("SUMO_HOME", None)
        command = [sys.executable, "-P", str(Path(__file__).with_name("worker.py"))]
        with self._messages.open("ab") as messages:
            self._process = subprocess.Popen(
                [*command, str(theirs.fileno()), str(self.folder)],
                stdin=subprocess.DEVNULL,
                stdout=messages,
                stderr=messages,
                pass_fds=[theirs.fileno()],
                env=environment,
                start_new_session=True,  # Ctrl-C at the terminal is for us alone
            )
        theirs.close()
        self.end = weakref.finalize(
            self, _end, os.getpid(), self._process, self._connection, self.folder
        )

    @property
    def alive(self) -> bool:
        """Whether it still answers."""
        return self.end.alive and self._process.poll() is None

    @property
    def messages(self) -> str:
        """What SUMO has printed since `forget_messages`."""
        return self._messages.read_text(encoding="utf-8", errors="replace")

    def forget_messages(self) -> None:
        """Empty the file of SUMO's messages."""
        os.truncate(self._messages, 0)

    def ask(self, verb: str, *arguments: object) -> Any:
        """Let the worker do something and return its answer; after any failure it has ended.

        Raises
        ------
        SimulationError
            If SUMO refuses or dies.
        """
        try:
            self._connection.send((verb, *arguments))
            outcome, answer = self._connection.recv()
        except (EOFError, OSError):
            self._stop(f"its process ended with code {self._code()}")
        except BaseException:
            self.end()  # an answer that nobody takes would be taken for that to the next question
            raise
        if outcome == "failed":
            self._stop(str(answer))
        return answer

    def _code(self) -> int | None:
        try:
            return self._process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            return None

    def _stop(self, problem: str) -> NoReturn:
        """End the worker and raise SUMO's complaint."""
        lines = [line.strip() for line in self.messages.splitlines()]
        said = [line for line in lines if line and not line.startswith("Warning:")]
        self.end()
        raise SimulationError(
            f"SUMO failed: {' / '.join([*said[-LAST_LINES:], problem])}", where=self._where
        )


def require_sumo() -> None:
    """Raise a MissingExtraError unless libsumo is installed."""
    if importlib.util.find_spec("libsumo") is None:
        raise MissingExtraError("sumo")


def _end(
    owner: int, process: subprocess.Popen[bytes], connection: Connection, folder: Path
) -> None:
    """Let the worker end, by force if it does not do so at once, and remove its files."""
    if os.getpid() != owner:
        return  # a forked copy of the owner: the worker is not its own
    connection.close()
    try:
        process.wait(PATIENCE_S if process.poll() is None else 0)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    shutil.rmtree(folder, ignore_errors=True)
