"""A simulator that is not ours, in a process of its own, from the side of ours."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import weakref
from collections.abc import Mapping
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, NoReturn

from dmil.errors import SimulationError

LAST_LINES = 5
"""How many lines of a simulator's complaint an error shows."""
PATIENCE_S = 5.0
"""How long a process may take to end by itself."""


class WorkerProcess:
    """A running worker and the folder of its files; both end with this.

    Parameters
    ----------
    simulator
        Name of the simulator that runs there, for errors.
    worker
        The program; it gets the handle of a pipe and the folder.
    environment
        Its environment.
    where
        What errors say it simulates.
    """

    def __init__(
        self, simulator: str, worker: Path, environment: Mapping[str, str], where: str
    ) -> None:
        self._simulator, self._where = simulator, where
        self.folder = Path(tempfile.mkdtemp(prefix=f"dmil-{simulator.lower()}-"))
        self._messages = self.folder / "messages.txt"
        self._connection, theirs = Pipe()
        with self._messages.open("ab") as messages:
            self._process = subprocess.Popen(
                [sys.executable, "-P", str(worker), str(theirs.fileno()), str(self.folder)],
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
        """What the simulator has printed since `forget_messages`."""
        return self._messages.read_text(encoding="utf-8", errors="replace")

    def forget_messages(self) -> None:
        """Empty the file of the simulator's messages."""
        os.truncate(self._messages, 0)

    def ask(self, verb: str, *arguments: object) -> Any:
        """Let the worker do something and return its answer; after any failure it has ended.

        Raises
        ------
        SimulationError
            If the simulator refuses or dies.
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
        """End the worker and raise the simulator's complaint."""
        lines = [line.strip() for line in self.messages.splitlines()]
        said = [line for line in lines if line and not line.startswith("Warning:")]
        self.end()
        raise SimulationError(
            f"{self._simulator} failed: {' / '.join([*said[-LAST_LINES:], problem])}",
            where=self._where,
        )


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
