"""Max-pressure as evaluation codes for CityFlow have it, to show that a recipe is the same."""

from __future__ import annotations

import numpy as np

from dmil.arrays import FloatArray, IntArray
from dmil.controllers import RunContext
from dmil.simulation import Observation
from dmil.simulation.cityflow import CityflowSimulator

NAME = "published-max-pressure"


class PublishedMaxPressure:
    """Serves the phase of the highest pressure, the first of equals (LLMLight's code).

    The pressure of a movement is what halts on its entering lanes minus what halts on all lanes of
    its exit road; roads out of the network count like others.

    Parameters
    ----------
    simulator
        Where it runs: it looks at lanes, which observations do not show.
    """

    def __init__(self, simulator: CityflowSimulator) -> None:
        self._simulator = simulator

    def reset(self, context: RunContext) -> None:
        """Note which lanes every movement comes from and leads to."""
        network = context.network
        index = network.link_index
        place = {lane: number for number, lane in enumerate(self._simulator.lanes)}
        roads: dict[int, list[int]] = {}
        for number, (link, _) in enumerate(self._simulator.lanes):
            roads.setdefault(link, []).append(number)
        self._items = network.intersections
        self._weights = []
        for item in self._items:
            weights = np.zeros((len(item.movements), len(place)))
            for j, move in enumerate(item.movements):
                weights[j, [place[index[move.from_link], lane] for lane in move.lanes]] += 1
                weights[j, roads[index[move.to_link]]] -= 1
            served = np.zeros((len(item.phases), len(item.movements)))
            for p, phase in enumerate(item.phases):
                served[p, sorted(phase)] = 1
            self._weights.append(served @ weights)

    def decide(self, observation: Observation, reward: FloatArray | None) -> IntArray:
        """Compare the pressures of all phases."""
        halting_veh = self._simulator.lane_halting_veh
        best = [int(np.argmax(weights @ halting_veh)) for weights in self._weights]
        return np.array(best, np.int32)
