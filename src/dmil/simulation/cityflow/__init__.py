"""The CityFlow simulator: the engine of its makers behind our protocol, a process for each run."""

from dmil.simulation.cityflow.simulator import CityflowSimulator

__all__ = ["CityflowSimulator"]
