"""Environments for algorithms of others: PettingZoo and Gymnasium (extra ``zoo``).

Importing this registers the Gymnasium environments of `ENVIRONMENTS`.
"""

from dmil.errors import MissingExtraError

try:
    import gymnasium  # noqa: F401
    import pettingzoo  # noqa: F401
except ImportError:
    raise MissingExtraError("zoo") from None

from dmil.interop import traffic_v0
from dmil.interop.intersection import ENVIRONMENTS, IntersectionEnv, register_environments
from dmil.interop.layout import VectorLayout
from dmil.interop.policies import ControllerPolicy, PredictController
from dmil.interop.traffic_v0 import TrafficEnv, env, parallel_env

register_environments()

__all__ = [
    "ENVIRONMENTS",
    "ControllerPolicy",
    "IntersectionEnv",
    "PredictController",
    "TrafficEnv",
    "VectorLayout",
    "env",
    "parallel_env",
    "register_environments",
    "traffic_v0",
]
