"""Beam search against the same search in plain Python."""

import numpy as np
import pytest

from dmil.controllers.planner.beam import AHEAD_INTERVALS, search
from dmil.controllers.planner.crossing import KnownIntersection
from dmil.scenarios import UniformTiming
from dmil.seeding import stream


def plain_lanes(lanes, ready, arrivals, begin_s, go_from_s, headway_s):
    """Let the vehicles of a movement come and go; return lanes, ready times, what was waited."""
    lanes, ready, waited = list(lanes), list(ready), 0
    for second, count in enumerate(arrivals):
        now = begin_s + second
        for _ in range(count):
            lanes[lanes.index(min(lanes))] += 1
        for lane in range(len(lanes)):
            while lanes[lane] and go_from_s <= now and ready[lane] < now + 1 - 1e-9:
                lanes[lane] -= 1
                ready[lane] = max(ready[lane], now) + headway_s
        waited += sum(lanes)
    return tuple(lanes), tuple(ready), waited


def plain_search(crossing, width):
    """Return phases and waiting of the best plan, as `search` does."""
    rules, served = crossing.rules, crossing.served
    interval_s = rules.decision_interval_s
    sizes = np.diff(crossing.lane_offset)
    decisions = len(crossing.arriving_veh) // interval_s
    nothing = tuple((0,) * size for size in sizes)
    # What was waited, how lanes stand, when they are ready, the phase, since when, and the way.
    states = [(0, nothing, tuple((0.0,) * size for size in sizes), -1, 0, ())]
    for decision in range(decisions):
        begin_s = decision * interval_s
        end_s = begin_s + interval_s
        ahead_s = 0 if decision == decisions - 1 else AHEAD_INTERVALS * interval_s
        arriving = crossing.arriving_veh[begin_s:end_s].T.tolist()
        found = []
        for waited, lanes, ready, shown, since_s, way in states:
            for phase in range(len(served)):
                green_s, anew_s = begin_s - since_s, begin_s + rules.startup_lost_s
                if shown >= 0 and phase != shown and green_s < rules.min_green_s:
                    continue
                too_long = 0 < rules.max_green_s <= green_s
                if phase == shown and too_long and len(served) > 1:
                    continue
                if shown >= 0:
                    anew_s += rules.clearance_s
                outcome = []
                for j in range(len(sizes)):
                    go_from_s = np.inf
                    keeps = shown >= 0 and served[[shown, phase], j].all()
                    stops = rules.all_stop and phase != shown
                    if crossing.unsignalled[j] or (keeps and not stops):
                        go_from_s = begin_s
                    elif served[phase, j]:
                        go_from_s = anew_s
                    outcome.append(
                        plain_lanes(
                            lanes[j], ready[j], arriving[j], begin_s, go_from_s, crossing.headway_s
                        )
                    )
                after, then, spent = zip(*outcome, strict=True)
                cost = waited + sum(spent)
                from_s = begin_s if shown < 0 else begin_s + rules.clearance_s
                from_s = since_s if phase == shown else from_s
                rank = cost + ahead_s * sum(map(sum, after))
                step = (*way, (phase, sum(spent)))
                found.append((rank, cost, after, then, phase, from_s, step))
        found.sort(key=lambda state: state[0])
        known, states = set(), []
        longest_s = max(rules.min_green_s, rules.max_green_s)
        for _, cost, after, then, phase, from_s, step in found:
            late = tuple(tuple(int(65536 * max(t - end_s, 0.0)) for t in lane) for lane in then)
            key = after, late
            if longest_s + rules.clearance_s + rules.startup_lost_s:
                key += phase, min(end_s - from_s, longest_s)
            if key not in known and len(states) < width:
                known.add(key)
                states.append((cost, after, then, phase, from_s, step))
    phases, waits = zip(*states[0][-1], strict=True)
    return list(phases), list(waits)


@pytest.mark.parametrize("case", range(18))
def test_plans_are_those_of_the_plain_search(case):
    rng = stream(case, "beam twin")
    movements, phases = int(rng.integers(2, 6)), int(rng.integers(1, 5))
    interval_s = int(rng.choice([1, 4, 10]))
    clearance_s = int(rng.integers(0, interval_s)) if case % 2 else 0
    max_green_s = int(rng.choice([0, 12]))
    rules = UniformTiming(
        decision_interval_s=interval_s,
        clearance_s=clearance_s,
        min_green_s=int(rng.choice([0, 5, 11])),
        max_green_s=max_green_s,
        startup_lost_s=int(rng.integers(0, interval_s - clearance_s + 1)) if case % 3 else 0,
        all_stop=case % 4 > 1,
    )
    unsignalled = rng.random(movements) < 0.2
    crossing = KnownIntersection(
        served=(rng.random((phases, movements)) < 0.5) & ~unsignalled,
        unsignalled=unsignalled,
        lane_offset=np.cumsum([0, *rng.integers(1, 3, movements)]).astype(np.int32),
        arriving_veh=rng.poisson(0.15, (6 * interval_s, movements)).astype(np.int32),
        headway_s=float(rng.choice([1.0, 2.0, 1 / 0.7])),
        rules=rules,
    )
    for width in (1, 7, 30):
        found, waited_veh_s = search(crossing, width)
        expected, expected_veh_s = plain_search(crossing, width)
        assert found.tolist() == expected
        assert waited_veh_s.tolist() == expected_veh_s
