"""Two simulators of one scenario: the same controllers and vehicles in both."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from dmil.controllers import make_controller
from dmil.rewards import make_reward
from dmil.scenarios import Scenario
from dmil.scenarios.calibration import Calibration
from dmil.simulation import QueueSimulator, Simulator
from dmil.simulation.measures import Measures
from dmil.simulation.sumo import SumoSimulator
from dmil.training.phases import evaluate, vehicles_of_seed

PLAIN, CALIBRATED, JUDGE = "queue", "queue, calibrated", "sumo"


@dataclass(frozen=True, slots=True)
class Agreement:
    """What one controller has come to in the simulators, means over seeds.

    Attributes
    ----------
    controller: str
    travel_time_s, delay_s: dict
        Simulator to value, see `dmil.simulation.measures.METRICS`.
    """

    controller: str
    travel_time_s: dict[str, float]
    delay_s: dict[str, float]


def agreement(
    scenario: Scenario,
    calibration: Calibration,
    controllers: Sequence[str],
    seeds: range,
    *,
    progress: Callable[[int, int], None] | None = None,
) -> list[Agreement]:
    """Run controllers in SUMO and in the queue simulator without and with a calibration (ours).

    Parameters
    ----------
    scenario, calibration
        What to simulate, and what was measured on it.
    controllers
        Names of controllers that do not learn.
    seeds
        Test seeds; in a seed all meet the same vehicles.
    progress
        Called with the number of finished runs and of all.
    """
    makers: dict[str, Callable[[], Simulator]] = {
        PLAIN: partial(QueueSimulator, scenario),
        CALIBRATED: partial(QueueSimulator, calibration.applied_to(scenario)),
        JUDGE: partial(SumoSimulator, scenario),
    }
    found: dict[tuple[str, str], list[Measures]] = {}
    total = len(makers) * len(controllers) * len(seeds)
    vehicles = {seed: vehicles_of_seed(scenario, seed) for seed in seeds}
    reward = make_reward("diffusion")
    if progress:
        progress(0, total)
    for where, make in makers.items():
        simulator = make()
        for name in controllers:
            for seed in seeds:
                controller = make_controller(name)
                run = evaluate(simulator, controller, vehicles[seed], reward, seed)
                found.setdefault((name, where), []).append(run.measures)
                if progress:
                    progress(sum(map(len, found.values())), total)
        if isinstance(simulator, SumoSimulator):
            simulator.close()

    def means(name: str, of: Callable[[Measures], float]) -> dict[str, float]:
        return {where: sum(map(of, found[name, where])) / len(seeds) for where in makers}

    return [
        Agreement(name, means(name, lambda m: m.travel_time_s), means(name, lambda m: m.delay_s))
        for name in controllers
    ]
