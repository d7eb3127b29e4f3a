"""PPO of stable-baselines3 on one intersection, compared with dmil's controllers.

Needs ``pip install 'dmil[zoo]' stable-baselines3``. Run it, about twenty seconds on one core:
``python examples/stable_baselines.py --steps 40000 --model ppo.zip``

Then evaluate the saved model, from the folder of this file: ``dmil evaluate --scenario grid:1x1
--load 2 --controller stable_baselines:TrainedPolicy --set model=ppo.zip``
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from functools import partial

import numpy as np
from stable_baselines3 import PPO
from stable_baselines3.common.env_util import make_vec_env

import dmil.interop  # noqa: F401  registers the environments
from dmil import REWARDS, QueueSimulator, evaluate, make_controller, scenario, vehicles_of_seed
from dmil.interop import PredictController

ENVIRONMENTS = 8
TRAINING_SEED = 1_000_000
"""First seed of the training vehicles, which differ from those of the test."""


class TrainedPolicy(PredictController):
    """A saved model as a controller, for the command line.

    Parameters
    ----------
    model
        File that stable-baselines3 saved.
    """

    def __init__(self, model: str = "ppo.zip") -> None:
        super().__init__(partial(PPO.load(model, device="cpu").predict, deterministic=True))


def train(load: float, steps: int) -> PPO:
    """Train PPO with the settings of stable-baselines3, but for shorter runs and horizon."""
    environments = make_vec_env(
        "dmil/Queue1x1-v0",
        ENVIRONMENTS,
        seed=TRAINING_SEED,
        env_kwargs={"reward": "queue", "load": load},
    )
    model = PPO(
        "MlpPolicy",
        environments,
        n_steps=64,
        batch_size=128,
        gamma=0.95,
        learning_rate=1e-3,
        seed=0,
        device="cpu",
    )
    model.learn(steps)
    environments.close()
    return model


def main(arguments: Sequence[str] | None = None) -> None:
    """Train, save, and compare on vehicles that training has not seen."""
    parser = argparse.ArgumentParser(description="PPO against this package's controllers.")
    parser.add_argument("--steps", type=int, default=40_000, help="decisions to train for")
    parser.add_argument("--load", type=float, default=2.0, help="factor on the demand")
    parser.add_argument("--seeds", type=int, default=20, help="test seeds")
    parser.add_argument("--model", default="ppo.zip", help="file to write")
    chosen = parser.parse_args(arguments)

    train(chosen.load, chosen.steps).save(chosen.model)
    ground = scenario("grid:1x1", load=chosen.load)
    simulator = QueueSimulator(ground)
    contenders = {
        "PPO": TrainedPolicy(chosen.model),
        "longest-queue-first": make_controller("longest-queue-first"),
        "max-pressure": make_controller("max-pressure"),
        "random": make_controller("random"),
    }
    travel_s = np.zeros((chosen.seeds, len(contenders)))
    for seed in range(chosen.seeds):
        vehicles = vehicles_of_seed(ground, seed)
        for k, controller in enumerate(contenders.values()):
            run = evaluate(simulator, controller, vehicles, REWARDS["queue"], seed)
            travel_s[seed, k] = run.measures.travel_time_s
    print(f"{ground.name}, mean travel time of {chosen.seeds} seeds in s; lower is better")
    for name, mean in zip(contenders, travel_s.mean(axis=0), strict=True):
        print(f"{name:>20}  {mean:6.2f}")


if __name__ == "__main__":
    main()
