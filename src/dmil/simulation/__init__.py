"""Simulators, what they show to controllers, and what is measured."""

from dmil.simulation.measures import Measures
from dmil.simulation.protocol import Observation, Simulator
from dmil.simulation.queue import QueueSimulator

__all__ = ["Measures", "Observation", "QueueSimulator", "Simulator"]
