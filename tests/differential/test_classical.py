"""The kernels of the classical controllers against their rules, written plainly."""

from itertools import product

import numpy as np
import pytest

from dmil.controllers import RunContext, make_controller
from dmil.controllers.rules.baselines import covering_phases
from dmil.controllers.rules.phase_choice import PhaseChoice
from dmil.network import grid
from dmil.scenarios import SignalTiming
from dmil.seeding import stream
from dmil.simulation import Observation
from dmil.simulation.pressure import movement_pressure

TIMING = SignalTiming(decision_interval_s=10, clearance_s=3)
CASES = list(product(("grid", "tee", "mixed"), range(4)))


@pytest.fixture
def course(tee, mixed_network):
    """Return a network and observations of it that hang together as far as controllers can tell."""

    def make(name, seed):
        network = {"grid": grid(2, 2), "tee": tee, "mixed": mixed_network}[name]
        rng = stream(seed, "classical", name)
        sizes = [len(node.movements) for node in network.intersections]
        counts = np.array([len(node.phases) for node in network.intersections])

        def see(decision, phases):
            queue_veh, approaching_veh = np.zeros((2, len(sizes), max(sizes)), np.int32)
            for i, size in enumerate(sizes):
                queue_veh[i, :size] = rng.poisson(rng.choice([0.1, 1, 5]), size)
                approaching_veh[i, :size] = rng.poisson(0.3, size)
            if phases is None:
                shown = np.full(counts.size, -1)
            else:
                # Now and then the signals show what was not asked for.
                other = rng.integers(0, counts)
                shown = np.where(rng.random(counts.size) < 0.9, phases, other)
            elapsed = rng.integers(0, 8, counts.size) * 10
            return Observation(
                queue_veh,
                approaching_veh,
                shown.astype(np.int32),
                elapsed.astype(np.int32),
                10 * decision,
                queue_veh.astype(float),
            )

        return network, see

    return make


def drive(controller, network, see, decisions=150):
    controller.reset(RunContext(network, TIMING, stream(0, "none")))
    phases = None
    for decision in range(decisions):
        seen = see(decision, phases)
        phases = controller.decide(seen, None)
        yield seen, phases.tolist()


def signalled(node, phase):
    return node.phases[phase] - node.unsignalled


def near(seen, i, movements):
    return sum(int(seen.queue_veh[i, j] + seen.approaching_veh[i, j]) for j in movements)


def plain_choice(node, weight, shown, cost):
    scores = []
    for phase in range(len(node.phases)):
        score = sum(weight[j] for j in signalled(node, phase))
        if shown not in (-1, phase):
            left = signalled(node, shown) - signalled(node, phase)
            score -= cost * max(0, sum(weight[j] for j in left))
        scores.append(score)
    best = max(scores)
    if shown >= 0 and scores[shown] >= best - 1e-9:
        return shown
    return next(phase for phase, score in enumerate(scores) if score >= best - 1e-9)


@pytest.mark.parametrize(("name", "seed"), CASES)
@pytest.mark.parametrize("hysteresis", [0.0, 0.7, 3.0])
def test_phases_of_the_highest_score(course, name, seed, hysteresis):
    network, see = course(name, seed)
    choice, rng = PhaseChoice(network, TIMING, hysteresis), stream(seed, "weights")
    phases, switched = None, 0
    for decision in range(150):
        seen = see(decision, phases)
        weight = seen.queue_veh - rng.poisson(1.0, seen.queue_veh.shape) / 3
        phases = choice.best(weight, seen.phase)
        for i, node in enumerate(network.intersections):
            shown = int(seen.phase[i])
            expected = plain_choice(node, weight[i].tolist(), shown, hysteresis * 3 / 7)
            assert phases[i] == expected
            switched += expected != shown
    assert switched > 0


@pytest.mark.parametrize(("name", "seed"), CASES)
def test_pressures(course, name, seed):
    network, see = course(name, seed)
    for decision in range(20):
        queue_veh = see(decision, None).queue_veh
        found = movement_pressure(queue_veh, network)
        for i, node in enumerate(network.intersections):
            for j, movement in enumerate(node.movements):
                onward = [
                    int(queue_veh[k, m])
                    for k, other in enumerate(network.intersections)
                    for m, following in enumerate(other.movements)
                    if following.from_link == movement.to_link
                ]
                mean = sum(onward) / len(onward) if onward else 0.0
                assert found[i, j] == queue_veh[i, j] - mean


def plain_gap_out(node, seen, i, place, options):
    """Return the place in the sequence that follows."""
    sequence = covering_phases(node)
    coming = [near(seen, i, signalled(node, phase)) for phase in sequence]
    if place is None:
        return next((k for k, count in enumerate(coming) if count), 0)
    if seen.phase[i] != sequence[place]:
        return place
    elapsed_s = int(seen.phase_elapsed_s[i])
    if elapsed_s < options["min_green_s"]:
        return place
    room = elapsed_s + TIMING.decision_interval_s <= options["max_green_s"]
    if coming[place] >= options["extend_veh"] and room:
        return place
    circle = [*range(place + 1, len(sequence)), *range(place)]
    return next((k for k in circle if coming[k]), place)


@pytest.mark.parametrize(("name", "seed"), CASES)
def test_gap_out(course, name, seed):
    network, see = course(name, seed)
    options = {"min_green_s": 20, "max_green_s": 50, "extend_veh": 2 + seed}
    places = dict.fromkeys(range(len(network.intersections)))
    moves = set()
    for seen, phases in drive(make_controller("gap-out", options), network, see):
        for i, node in enumerate(network.intersections):
            before, places[i] = places[i], plain_gap_out(node, seen, i, places[i], options)
            assert phases[i] == covering_phases(node)[places[i]]
            moves.add((before, places[i]))
    assert len(moves) > 5


@pytest.mark.parametrize(("name", "seed"), CASES)
def test_self_organising_lights(course, name, seed):
    network, see = course(name, seed)
    theta, least_s, mu = 40.0 * seed, 10 * (seed + 1), seed
    options = {"theta_veh_s": theta, "min_green_s": least_s, "mu_veh": mu}
    kappa = [[0.0] * len(node.movements) for node in network.intersections]
    reasons = set()
    for seen, phases in drive(make_controller("sotl", options), network, see):
        for i, node in enumerate(network.intersections):
            shown = int(seen.phase[i])
            green = signalled(node, shown) if shown >= 0 else frozenset()
            for j in range(len(node.movements)):
                kappa[i][j] = 0 if j in green else kappa[i][j] + 10 * near(seen, i, [j])
            totals = [
                sum(kappa[i][j] for j in signalled(node, phase))
                for phase in range(len(node.phases))
            ]
            asked, coming = max(totals), near(seen, i, green)
            ready = (
                seen.phase_elapsed_s[i] >= least_s,
                asked > 0 and asked >= theta,
                not 0 < coming < mu,
            )
            switches = shown < 0 or all(ready)
            assert phases[i] == (totals.index(asked) if switches else shown)
            reasons.add(ready)
    assert len(reasons) > 1
