"""Memory-based multi-agent traffic-signal control: train, compare, inspect.

Names are loaded when they are first used, so that ``import dmil`` costs nothing.
"""

# No import before these, which Python itself has imported already.
import os
import sys

# "python -m dmil" looks for every module in the current folder first: a file json.py there would
# run. Only where dmil itself lies in that folder it has to be found again.
_OUR_FOLDER = os.path.dirname(os.path.dirname(__file__))
_AS_MODULE = sys.argv[:1] == ["-m"] and not {"dmil", "-mdmil"}.isdisjoint(sys.orig_argv)
if _AS_MODULE and not sys.flags.safe_path and sys.path[0] != _OUR_FOLDER:
    del sys.path[0]

import importlib  # noqa: E402
from typing import TYPE_CHECKING, Any  # noqa: E402

from dmil.version import __version__  # noqa: E402

# ruff: noqa: F401  for type checkers only; __all__ is made from the same names below.
if TYPE_CHECKING:
    from dmil.controllers import CONTROLLERS, Controller, RunContext, make_controller
    from dmil.demand import CompoundPoissonDemand, PoissonDemand, ProfileDemand, Vehicles
    from dmil.errors import DmilError
    from dmil.importing import trust
    from dmil.network import RoadNetwork, grid, read_cityflow_roadnet
    from dmil.results import Results
    from dmil.rewards import REWARDS, RewardConstants, make_reward
    from dmil.scenarios import QueueDynamics, Scenario, SignalTiming, cityflow_scenario, scenario
    from dmil.seeding import stream
    from dmil.simulation import Measures, Observation, QueueSimulator, Simulator
    from dmil.studies import PaperStudy, PaperStudySettings, run_study
    from dmil.studies.report import write_report
    from dmil.symmetry import EMBEDDINGS, Embedding
    from dmil.training import (
        controller_of,
        evaluate,
        load_policy,
        policy_of,
        run,
        save_policy,
        train,
        train_prior,
        vehicles_of_seed,
    )

_ROOMS = {
    "controllers": ("CONTROLLERS", "Controller", "RunContext", "make_controller"),
    "demand": ("CompoundPoissonDemand", "PoissonDemand", "ProfileDemand", "Vehicles"),
    "errors": ("DmilError",),
    "importing": ("trust",),
    "network": ("RoadNetwork", "grid", "read_cityflow_roadnet"),
    "results": ("Results",),
    "rewards": ("REWARDS", "RewardConstants", "make_reward"),
    "scenarios": ("QueueDynamics", "Scenario", "SignalTiming", "cityflow_scenario", "scenario"),
    "seeding": ("stream",),
    "simulation": ("Measures", "Observation", "QueueSimulator", "Simulator"),
    "studies": ("PaperStudy", "PaperStudySettings", "run_study"),
    "studies.report": ("write_report",),
    "symmetry": ("EMBEDDINGS", "Embedding"),
    "training": (
        "controller_of",
        "evaluate",
        "load_policy",
        "policy_of",
        "run",
        "save_policy",
        "train",
        "train_prior",
        "vehicles_of_seed",
    ),
}
_ROOM_OF = {name: room for room, names in _ROOMS.items() for name in names}

__all__ = sorted(_ROOM_OF)


def __getattr__(name: str) -> Any:
    """Load a public name from its room."""
    if name not in _ROOM_OF:
        raise AttributeError(f"module 'dmil' has no attribute '{name}'")
    return getattr(importlib.import_module(f"dmil.{_ROOM_OF[name]}"), name)


def __dir__() -> list[str]:
    """List the public names."""
    return [*__all__, "__version__"]
