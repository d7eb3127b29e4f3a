"""The process that a run of CityFlow has, from the side of the simulator."""

from __future__ import annotations

import importlib.util
import os
from pathlib import Path

from dmil.errors import InputError
from dmil.simulation.worker_process import WorkerProcess


class CityflowProcess(WorkerProcess):
    """A running `dmil.simulation.cityflow.worker` and the folder of its files; both end with this.

    Parameters
    ----------
    where
        What errors say it simulates.

    Raises
    ------
    InputError
        If the module ``cityflow`` is not there.
    """

    def __init__(self, where: str) -> None:
        folder = str(_module().parent)
        paths = [each for each in (os.environ.get("PYTHONPATH", ""), folder) if each]
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(paths)}
        super().__init__("CityFlow", Path(__file__).with_name("worker.py"), environment, where)


def has_cityflow() -> bool:
    """Tell whether the module ``cityflow`` can be imported."""
    found = importlib.util.find_spec("cityflow")
    return found is not None and found.origin is not None  # a folder of that name is none


def require_cityflow() -> None:
    """Raise an InputError unless the module ``cityflow`` can be imported."""
    _module()


def _module() -> Path:
    """Return the file of the module; an `InputError` if there is none."""
    found = importlib.util.find_spec("cityflow")
    if found is None or found.origin is None:
        raise InputError(
            "the Python module 'cityflow' is not installed",
            where="simulator cityflow",
            expected="CityFlow's engine, which is no dependency of dmil",
            mend="build it from the repository of its makers, cityflow-project/CityFlow, as its "
            "README says, or use the simulator queue",
        )
    return Path(found.origin)
