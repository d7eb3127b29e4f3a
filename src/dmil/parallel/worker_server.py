"""The server that forks worker processes: begun once, deaf to Ctrl-C and the current folder."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import forkserver, resource_tracker

SAFE_PATH = "PYTHONSAFEPATH"
"""Variable that keeps Python from looking for modules in the current folder first."""


def start_worker_server(module: str) -> None:
    """Begin the server of worker processes, unless it runs already.

    It imports while this process goes on. Ctrl-C reaches every process of a terminal, but only
    this one shall act on it: while the server still imports it would print a traceback. Nor shall
    it run a file ``socket.py`` that happens to lie in the current folder.

    Parameters
    ----------
    module
        What the workers work with: the server imports it once for all of them.
    """
    multiprocessing.set_forkserver_preload([module])
    with _safe_path():
        resource_tracker.ensure_running()  # within the next lines, it would let signals through
        before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
        try:
            forkserver.ensure_running()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _safe_path() -> Iterator[None]:
    """Let child processes begin without the current folder on their path."""
    before = os.environ.get(SAFE_PATH)
    os.environ[SAFE_PATH] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ[SAFE_PATH]
        else:
            os.environ[SAFE_PATH] = before
