"""Checks of a reward."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from enum import StrEnum
from itertools import chain, product

import numpy as np

from dmil.arrays import FloatArray
from dmil.controllers import make_controller
from dmil.network import RoadNetwork
from dmil.scenarios import Scenario
from dmil.simulation import Observation, QueueSimulator
from dmil.testing.conformance import Witness, array_in_words
from dmil.testing.proving_grounds import proving_grounds
from dmil.testing.trials import chance, no_reward
from dmil.training import run, vehicles_of_seed

CROWD_VEH = 1000
"""Vehicles per movement of a network that is full."""


class RewardRule(StrEnum):
    """What every reward keeps."""

    RUNS = "it works on every network, empty or crowded"
    SHAPE = "it returns an array with one float64 per intersection"
    FINITE = "every reward is a finite number"
    INPUTS = "it does not change the observations"
    PURE = "it depends on its arguments only"
    SNAPSHOT = "a reward that was returned does not change later"


def check_reward(function: Callable[..., object]) -> None:
    """Check a reward on networks of different shapes.

    Parameters
    ----------
    function
        Takes the observations before and after an interval and the network, see
        `dmil.rewards.Reward`.

    Raises
    ------
    ConformanceError
        At the first rule that is broken, see `RewardRule`.
    """
    witness = Witness(getattr(function, "__qualname__", type(function).__name__))
    intervals = list(chain.from_iterable(map(_intervals, proving_grounds())))
    returned, kept = [], []
    for interval in intervals:
        returned.append(_checked(function, witness, *interval))
        kept.append(returned[-1].copy())
    for interval, reward in reversed(list(zip(intervals, kept, strict=True))):
        again = _checked(function, witness, *interval)
        found = "called again with the same arguments, {}"
        same = "the same reward, whatever was asked in between"
        witness.expect_same(RewardRule.PURE, reward, again, "reward", found, same)
    for (place, *_), reward, now in zip(intervals, kept, returned, strict=True):
        witness.where = place
        told = "later calls changed {}", "a new array from every call"
        witness.expect_same(RewardRule.SNAPSHOT, reward, now, "reward", *told)


def _intervals(ground: Scenario) -> list[tuple[str, Observation, Observation, RoadNetwork]]:
    """Return intervals of a run, and between an empty and a full network, with place in words."""
    found = []

    def record(before: Observation, after: Observation, network: RoadNetwork) -> FloatArray:
        place = f"interval from {before.time_s} s to {after.time_s} s on {ground.name}"
        found.append((place, before, after, network))
        return no_reward(before, after, network)

    vehicles = vehicles_of_seed(ground, 0)
    run(QueueSimulator(ground), make_controller("random"), vehicles, record, chance("reward"))
    _, empty, after, network = found[0]
    counts = np.zeros_like(empty.queue_veh)
    for i, item in enumerate(network.intersections):
        counts[i, : len(item.movements)] = CROWD_VEH
    states = {
        name: replace(
            after, queue_veh=veh, approaching_veh=veh.copy(), waiting_veh=veh.astype(np.float64)
        )
        for name, veh in (("an empty", np.zeros_like(counts)), ("a crowded", counts))
    }
    for before, then in product(states, repeat=2):
        place = f"interval from {before} to {then} network, {ground.name}"
        found.append((place, states[before], states[then], network))
    return found


def _checked(
    function: Callable[..., object],
    witness: Witness,
    place: str,
    before: Observation,
    after: Observation,
    network: RoadNetwork,
) -> FloatArray:
    witness.where = place
    with (
        witness.no_exception(RewardRule.RUNS, "it"),
        witness.no_global_chance(RewardRule.PURE),
        witness.no_change(RewardRule.INPUTS, before=before, after=after),
    ):
        reward = function(before, after, network)
    shape = (len(network.intersections),)
    if not (
        isinstance(reward, np.ndarray) and reward.shape == shape and reward.dtype == np.float64
    ):
        expected = f"an array of shape {shape} and type float64"
        witness.fail(RewardRule.SHAPE, array_in_words(reward), expected)
    i = int(np.isfinite(reward).argmin())
    witness.expect(
        np.isfinite(reward[i]),
        RewardRule.FINITE,
        f"{reward[i]} at intersection '{network.intersections[i].id}'",
        "a finite number",
    )
    return reward
