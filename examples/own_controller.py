"""Your own controller against max-pressure, on the same vehicles.

Run it: ``python examples/own_controller.py --scenario grid:3x3 --seeds 10``
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import numpy as np

from dmil import (
    REWARDS,
    Observation,
    QueueSimulator,
    RunContext,
    evaluate,
    make_controller,
    scenario,
    vehicles_of_seed,
)
from dmil.testing import check_controller


class ActuatedController:
    """Gap-based control: a phase stays green until the traffic that it serves has a gap.

    A phase without vehicles queued or approaching gives way at once to the next one in the cycle
    that has some; one with traffic gives way when it has been green for ``max_green_s``.

    Parameters
    ----------
    max_green_s
        Longest green while others wait.
    """

    def __init__(self, max_green_s: float = 20.0) -> None:
        self.max_green_s = max_green_s

    def reset(self, context: RunContext) -> None:
        """Note which movements the signals serve in each phase."""
        self._served = [
            [sorted(phase - item.unsignalled) for phase in item.phases]
            for item in context.network.intersections
        ]

    def decide(self, observation: Observation, reward: np.ndarray | None) -> np.ndarray:
        """Keep or change the phase of every intersection; rewards are of no interest."""
        coming_veh = observation.queue_veh + observation.approaching_veh
        phases = np.zeros(len(self._served), np.int32)
        for i, served in enumerate(self._served):
            shown = max(int(observation.phase[i]), 0)
            demand_veh = [int(coming_veh[i, movements].sum()) for movements in served]
            in_time = observation.phase_elapsed_s[i] < self.max_green_s
            phases[i] = shown
            if not (demand_veh[shown] and in_time):
                turn = [(shown + step) % len(served) for step in range(1, len(served))]
                phases[i] = next((phase for phase in turn if demand_veh[phase]), shown)
        return phases


def main(arguments: Sequence[str] | None = None) -> None:
    """Check the controller, run both, print both."""
    parser = argparse.ArgumentParser(description="Gap-based control against max-pressure.")
    parser.add_argument("--scenario", default="grid:3x3")
    parser.add_argument("--seeds", type=int, default=10)
    chosen = parser.parse_args(arguments)

    check_controller(ActuatedController)
    ground = scenario(chosen.scenario)
    simulator = QueueSimulator(ground)
    contenders = {"actuated": ActuatedController(), "max-pressure": make_controller("max-pressure")}
    wait = np.zeros((chosen.seeds, len(contenders)))
    for seed in range(chosen.seeds):
        vehicles = vehicles_of_seed(ground, seed)
        for k, controller in enumerate(contenders.values()):
            run = evaluate(simulator, controller, vehicles, REWARDS["queue"], seed)
            wait[seed, k] = run.measures.w_over_vc
    print(f"{ground.name}, mean of {chosen.seeds} seeds, W/V_c in s per vehicle; lower is better")
    for name, mean in zip(contenders, wait.mean(axis=0), strict=True):
        print(f"{name:>12}  {mean:.4f}")
    better = int((wait[:, 0] < wait[:, 1]).sum())
    print(f"actuated waits less in {better} of {chosen.seeds} seeds")


if __name__ == "__main__":
    main()
