"""Settings of all tests, and networks and journeys that several of them drive on."""

import os
import signal
import sys
from dataclasses import replace
from pathlib import Path

# Each worker has one core: threads that wait for work only take it from the other one.
os.environ.setdefault("POLARS_MAX_THREADS", "1")

import numpy as np
import pytest
from hypothesis import settings

from dmil.demand import Vehicles
from dmil.network import Intersection, Link, Movement, RoadNetwork, grid

# The first call of a kernel compiles it, so a deadline would judge the machine. The same examples
# every time: a green commit stays green.
settings.register_profile("dmil", deadline=None, derandomize=True)
settings.load_profile("dmil")

# Who runs the tests in the background of a script has them ignore Ctrl-C, and whatever they start.
if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# Coverage follows the tests into the workers of pytest-xdist, and no further: it would make
# each process that a test starts slower by a second or more.
if "PYTEST_XDIST_WORKER" in os.environ:
    os.environ.pop("COVERAGE_PROCESS_CONFIG", None)

# These compute for long in plain Python, which tracing makes two to three times slower. They judge
# what is computed; which lines are covered the others show.
UNTRACED = {"differential", "end_to_end", "properties", "verification"}


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item):
    """Let coverage pause while a test runs that does not count for it."""
    tracer = sys.gettrace()
    if tracer is None or item.path.relative_to(Path(__file__).parent).parts[0] not in UNTRACED:
        return (yield)
    sys.settrace(None)
    try:
        return (yield)
    finally:
        sys.settrace(tracer)


@pytest.fixture(scope="session")
def tee() -> RoadNetwork:
    """A three-way junction: 6 movements, 3 phases, the right turn from the South always may go."""
    ways = ("E>T", "T>W", "straight", 0), ("E>T", "T>S", "left", 0), ("W>T", "T>S", "right", 1)
    ways += ("W>T", "T>E", "straight", 1), ("S>T", "T>E", "right", 2), ("S>T", "T>W", "left", 2)
    junction = Intersection(
        "T",
        tuple(Movement(*way, lanes=(k % 2,)) for k, way in enumerate(ways)),
        (frozenset({0, 2, 3}), frozenset({0, 1}), frozenset({2, 5})),
        frozenset({4}),
    )
    links = [Link(f"{side}>T", side, "T", 40.0, 10.0, 2) for side in "EWS"]
    links += [Link(f"T>{side}", "T", side, 20.0, 10.0, 1) for side in "EWS"]
    position_m = {"T": (0.0, 0.0), "E": (40.0, 0.0), "W": (-40.0, 0.0), "S": (0.0, -40.0)}
    return RoadNetwork("tee", tuple(links), (junction,), ("E", "W", "S"), position_m)


@pytest.fixture(scope="session")
def mixed_network() -> RoadNetwork:
    """A 2×3 grid without one inner road and one entry: three- and four-way intersections."""
    full = grid(2, 3)
    removed = {"0,0>0,1", "0,1>0,0", "N2>0,2", "0,2>N2"}
    return replace(
        full,
        name="mixed",
        links=tuple(link for link in full.links if link.id not in removed),
        intersections=tuple(_without(removed, node) for node in full.intersections),
        fringe=tuple(node for node in full.fringe if node != "N2"),
    )


def _without(removed: set[str], node: Intersection) -> Intersection:
    stay = [
        j
        for j, movement in enumerate(node.movements)
        if not {movement.from_link, movement.to_link} & removed
    ]
    phases = (frozenset(stay.index(j) for j in phase if j in stay) for phase in node.phases)
    return replace(
        node,
        movements=tuple(node.movements[j] for j in stay),
        phases=tuple(dict.fromkeys(phase for phase in phases if phase)),
        unsignalled=frozenset(stay.index(j) for j in node.unsignalled if j in stay),
        phase_names=(),
    )


@pytest.fixture(scope="session")
def varied():
    """A function that gives a network roads and lanes of all kinds."""

    def vary(network, rng):
        links = tuple(
            replace(
                link,
                length_m=float(rng.choice([0.0, 4.0, 25.0, 60.0, 110.0])),
                speed_m_per_s=float(rng.uniform(5, 15)),
                lanes=int(rng.integers(1, 4)),
            )
            for link in network.links
        )
        lanes = {link.id: link.lanes for link in links}

        def some_lanes(link):
            chosen = rng.choice(lanes[link], rng.integers(1, lanes[link] + 1), replace=False)
            return tuple(sorted(chosen.tolist()))

        def some_priorities(count):
            rank = rng.permutation(count)
            foes = (np.flatnonzero((rank < own) & (rng.random(count) < 0.1)) for own in rank)
            return tuple(tuple(each.tolist()) for each in foes)

        intersections = tuple(
            replace(
                node,
                movements=tuple(
                    replace(movement, lanes=some_lanes(movement.from_link))
                    for movement in node.movements
                ),
                gives_way=some_priorities(len(node.movements)),
            )
            for node in network.intersections
        )
        return replace(network, links=links, intersections=intersections)

    return vary


@pytest.fixture(scope="session")
def one_lane():
    """A function that leaves a network one lane on every road, which all movements share."""

    def narrow(network):
        return replace(
            network,
            links=tuple(replace(link, lanes=1) for link in network.links),
            intersections=tuple(
                replace(
                    node,
                    movements=tuple(replace(movement, lanes=(0,)) for movement in node.movements),
                )
                for node in network.intersections
            ),
        )

    return narrow


@pytest.fixture(scope="session")
def wander():
    """A function that draws vehicles that turn at random; some park on a link inside."""

    def draw(network, horizon_s, veh_per_s, rng, longest=10) -> Vehicles:
        depart_s = np.sort(rng.integers(0, horizon_s, rng.poisson(horizon_s * veh_per_s)))
        routes = []
        for _ in depart_s:
            route = [int(rng.choice(network.entry_links))]
            while len(route) < longest and network.successors[route[-1]]:
                following = network.successors[route[-1]]
                route.append(following[rng.integers(len(following))][0])
            routes.append(route)
        offset = np.cumsum([0, *map(len, routes)]).astype(np.int32)
        links = np.array([link for route in routes for link in route], np.int32)
        return Vehicles(depart_s.astype(np.int32), offset, links)

    return draw
