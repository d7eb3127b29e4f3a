"""The server that forks worker processes: begun once, and deaf to Ctrl-C."""

from __future__ import annotations

import multiprocessing
import signal
from multiprocessing import forkserver, resource_tracker


def start_worker_server(module: str) -> None:
    """Begin the server of worker processes, unless it runs already (ours).

    It imports while this process goes on. Ctrl-C reaches every process of a terminal, but only
    this one shall act on it: while the server still imports it would print a traceback.

    Parameters
    ----------
    module
        What the workers work with: the server imports it once for all of them.
    """
    multiprocessing.set_forkserver_preload([module])
    resource_tracker.ensure_running()  # begun within the next lines, it would let signals through
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        forkserver.ensure_running()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
