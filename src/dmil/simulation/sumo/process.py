"""The process that SUMO runs in, from the side of the simulator."""

from __future__ import annotations

import importlib.util
import os
from pathlib import Path

from dmil.errors import MissingExtraError
from dmil.simulation.worker_process import WorkerProcess


class SumoProcess(WorkerProcess):
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
        environment = dict(os.environ)
        if importlib.util.find_spec("sumo"):
            # libsumo then takes the folder of the installed package, not that of another SUMO.
            environment.pop("SUMO_HOME", None)
        super().__init__("SUMO", Path(__file__).with_name("worker.py"), environment, where)


def require_sumo() -> None:
    """Raise a MissingExtraError unless libsumo is installed."""
    if importlib.util.find_spec("libsumo") is None:
        raise MissingExtraError("sumo")
