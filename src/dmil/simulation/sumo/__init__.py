"""The SUMO simulator: Eclipse SUMO behind the protocol of all simulators, one process each."""

from dmil.simulation.sumo.signals import ACTUATED
from dmil.simulation.sumo.simulator import SumoSimulator

__all__ = ["ACTUATED", "SumoSimulator"]
