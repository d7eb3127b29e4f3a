"""Simulators, what they show to controllers, and what is measured."""

from dmil.simulation.disturbances import ClosedLane, DisturbedSimulator, Sensors
from dmil.simulation.measures import Measures
from dmil.simulation.protocol import Observation, Simulator
from dmil.simulation.queue import QueueSimulator
from dmil.simulation.registry import SIMULATORS, make_simulator
from dmil.simulation.sumo import SumoSimulator

__all__ = [
    "SIMULATORS",
    "ClosedLane",
    "DisturbedSimulator",
    "Measures",
    "Observation",
    "QueueSimulator",
    "Sensors",
    "Simulator",
    "SumoSimulator",
    "make_simulator",
]
