"""The SUMO simulator: Eclipse SUMO behind the protocol of all simulators, one process each."""

from dmil.simulation.sumo.simulator import SumoSimulator

__all__ = ["SumoSimulator"]
