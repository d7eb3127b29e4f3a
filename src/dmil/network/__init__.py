"""Road networks: frozen data, a grid builder, readers of files, checks."""

from dmil.network.checks import check_network
from dmil.network.cityflow import read_cityflow_roadnet
from dmil.network.grid import grid
from dmil.network.model import (
    TURNS,
    Intersection,
    Junction,
    Link,
    Movement,
    RoadNetwork,
    Turn,
    Walk,
)
from dmil.network.naming import exit_sides, shape_signature
from dmil.network.plan_times import PlanTimes, plan_times
from dmil.network.program import Program, Stage
from dmil.network.sumo import Remark, SumoNetwork, SumoSignals, read_sumo_network

__all__ = [
    "TURNS",
    "Intersection",
    "Junction",
    "Link",
    "Movement",
    "PlanTimes",
    "Program",
    "Remark",
    "RoadNetwork",
    "Stage",
    "SumoNetwork",
    "SumoSignals",
    "Turn",
    "Walk",
    "check_network",
    "exit_sides",
    "grid",
    "plan_times",
    "read_cityflow_roadnet",
    "read_sumo_network",
    "shape_signature",
]
