"""An equivariant class is controlled by the transformed signal (paper, §IV-A), end to end."""

import numpy as np
import pytest

from dmil.controllers import Prior, RunContext
from dmil.controllers.tabular.agents import agents_of, classes_of
from dmil.controllers.tabular.dual_memory import DualMemoryController
from dmil.controllers.tabular.sarsa import SarsaController
from dmil.controllers.tabular.settings import DualMemorySettings, SarsaSettings
from dmil.demand import Vehicles
from dmil.memory import pack, unpack_values
from dmil.rewards import REWARDS
from dmil.scenarios import SignalTiming, scenario
from dmil.seeding import stream
from dmil.simulation import Observation, QueueSimulator
from dmil.symmetry import EMBEDDINGS, embed, vary

SCENARIO = scenario("grid:1x1", horizon_s=600)
NETWORK = SCENARIO.network
GROUP = agents_of(NETWORK).groups[0]
CLASSES = classes_of(NETWORK, EMBEDDINGS["complex"])
SIDES = ("E0", "N0", "W0", "S0")


def vehicles(seed):
    return SCENARIO.demand.vehicles(NETWORK, SCENARIO.horizon_s, stream(seed, "demand"))


def run(controller, journeys, rng):
    """Return what was seen and done at every decision."""
    simulator = QueueSimulator(SCENARIO)
    controller.reset(RunContext(NETWORK, SignalTiming(), rng))
    observation, reward, done = simulator.reset(journeys), None, []
    while observation.time_s < SCENARIO.horizon_s:
        action = controller.decide(observation, reward)
        done.append((observation.queue_veh[0].tolist(), int(action[0])))
        following = simulator.advance(action)
        reward = REWARDS["diffusion"](observation, following, NETWORK)
        observation = following
    return done


def trained(kind):
    make, settings = {
        "sarsa": (SarsaController, SarsaSettings),
        "dual-memory": (DualMemoryController, DualMemorySettings),
    }[kind]
    controller = make(settings(embedding="complex"))
    seen = [
        state for seed in range(6) for state, _ in run(controller, vehicles(seed), stream(seed))
    ]
    frozen = make(settings(embedding="complex", epsilon=0.0, learning=False))
    frozen.reset(RunContext(NETWORK, SignalTiming(), stream(0)))
    frozen.restore(controller.arrays())
    return frozen, seen


def shown(controller, state):
    """Return the action for a state, None if it is left to chance."""
    queue = np.array([state], np.int32)
    empty = np.zeros(1, np.int32)
    observation = Observation(queue, np.zeros_like(queue), empty, empty, 0, np.zeros(queue.shape))
    actions = {int(controller.decide(observation, None)[0]) for _ in range(6)}
    return actions.pop() if len(actions) == 1 else None


def rotated(state, turn):
    moved = np.zeros(12, np.int32)
    moved[GROUP.movement_image[turn]] = state
    return moved.tolist()


def variants_of(state):
    places = CLASSES.movement_image.shape[2]
    key, variants = np.zeros(places, np.int32), np.zeros((4, places), np.int32)
    embed(CLASSES, np.array(state, np.int32), key)
    vary(CLASSES, 0, key, variants)
    return variants


def has_one_nearest(state, tables):
    """Tell whether no two keys or rotations are equally near, so that order decides nothing."""
    for keys in tables:
        whole = np.abs(keys[:, None] - variants_of(state)[None])
        # The first part in which a key is near decides.
        for off in np.split(whole, CLASSES.parts, axis=2):
            distances = np.sort(off.sum(axis=2)[off.max(axis=2) <= 1])
            if len(distances) > 1 and distances[0] == distances[1]:
                return False
            if len(distances):
                break
    return True


@pytest.mark.parametrize("kind", ["sarsa", "dual-memory"])
def test_a_rotated_observation_gets_the_rotated_action(kind):
    controller, seen = trained(kind)
    parts = [controller.table] if kind == "sarsa" else controller.memory[:2]
    tables = [part.rows.keys[0, : part.rows.size[0]] for part in parts]
    compared = set()
    for state in map(list, sorted(set(map(tuple, seen)))):
        action = shown(controller, state)
        if action is None or not has_one_nearest(state, tables):
            continue
        for turn in range(4):
            expected = GROUP.phase_image[turn, action]
            assert shown(controller, rotated(state, turn)) == expected
        compared.add(action)
    # All kinds of phases were met, or the test would show little.
    assert len(compared) >= 6


class RotatedChance:
    """The same coins, except that an action drawn at random is drawn rotated."""

    def __init__(self, rng, turn):
        self.rng, self.image = rng, GROUP.phase_image[turn]

    def random(self, shape):
        draws = self.rng.random(shape)
        draws[:, 1] = (self.image[(draws[:, 1] * 8).astype(int)] + 0.5) / 8
        return draws


def rotated_vehicles(journeys, turn):
    """Return the same journeys with every side's name moved on."""
    sides = GROUP.movement_image[turn, ::3] // 3
    name = {old: SIDES[sides[s]] for s, old in enumerate(SIDES)}
    name["0,0"] = "0,0"
    link = [NETWORK.link_index[f"{name[item.start]}>{name[item.end]}"] for item in NETWORK.links]
    moved = np.array(link, np.int32)[journeys.route_links]
    return Vehicles(journeys.depart_s, journeys.route_offset, moved)


def rotated_prior(prior, turn):
    arrays = pack(prior.table)
    moved = {name: np.zeros_like(array) for name, array in arrays.items()}
    moved["size"], moved["visits"] = arrays["size"], arrays["visits"]
    moved["keys"][:, GROUP.movement_image[turn]] = arrays["keys"]
    for name in ("value", "tried"):
        moved[name][:, GROUP.phase_image[turn]] = arrays[name]
    return Prior(unpack_values(moved, prior.table))


@pytest.mark.parametrize("turn", [1, 2, 3])
@pytest.mark.parametrize("epsilon", [0.0, 0.4])
def test_rotated_demand_and_prior_give_rotated_phases(turn, epsilon):
    dummy = SarsaController(SarsaSettings(embedding="exact", epsilon=0.1, shared=True))
    run(dummy, vehicles(90), stream(90))
    prior = Prior(dummy.table)
    settings = DualMemorySettings(embedding="complex", epsilon=epsilon)
    journeys = vehicles(3)
    done = run(DualMemoryController(settings, prior=prior), journeys, stream(3))
    turned = run(
        DualMemoryController(settings, prior=rotated_prior(prior, turn)),
        rotated_vehicles(journeys, turn),
        RotatedChance(stream(3), turn),
    )
    image = GROUP.phase_image[turn]
    assert turned == [(rotated(state, turn), image[action]) for state, action in done]
    assert len({action for _, action in done}) >= 6
