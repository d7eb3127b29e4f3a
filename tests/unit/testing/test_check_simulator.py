"""Every rule for simulators catches a simulator that breaks it, and ours keeps them."""

from dataclasses import replace

import numpy as np
import pytest

from dmil import QueueDynamics, QueueSimulator, SignalTiming, scenario
from dmil.errors import InputError
from dmil.seeding import stream
from dmil.simulation.queue.state import TIME, VISITS
from dmil.testing import ConformanceError, SimulatorRule, check_simulator
from dmil.testing.proving_grounds import proving_grounds
from dmil.training import vehicles_of_seed

SMALL = scenario("grid:1x2", horizon_s=205)


@pytest.mark.parametrize("ground", proving_grounds(), ids=lambda ground: ground.name)
def test_our_simulator_conforms(ground):
    check_simulator(lambda: QueueSimulator(ground))


def test_our_simulator_conforms_with_storage_and_slow_signals():
    timing = SignalTiming(decision_interval_s=7, clearance_s=3, min_green_s=10, startup_lost_s=2)
    dynamics = QueueDynamics(storage=True, saturation_flow_veh_per_s=0.4)
    crowded = scenario("grid:2x2", timing=timing, dynamics=dynamics, load=2.0)
    vehicles = vehicles_of_seed(crowded, 3)
    check_simulator(lambda: QueueSimulator(crowded), vehicles)


def small(**methods):
    """Make a simulator that does something else, and say how to make it."""
    kind = type("Wrong", (QueueSimulator,), methods)
    return lambda: kind(SMALL)


def shows(change):
    """Change an observation: ``change`` gets it and returns the fields that are different."""

    def observe(self, *seen):
        observation = QueueSimulator._observe(self, *seen)
        return replace(observation, **change(observation))

    return small(_observe=observe)


def counts(change):
    """Change the measures, likewise."""

    def measures(self):
        measured = QueueSimulator.measures(self)
        return replace(measured, **change(measured))

    return small(measures=measures)


def lays_out(**change):
    """Change who is served."""

    class Wrong(QueueSimulator):
        def __init__(self):
            super().__init__(SMALL)
            signals = self._layout.signals
            fields = {name: rule(getattr(signals, name)) for name, rule in change.items()}
            self._layout = self._layout._replace(signals=signals._replace(**fields))

    return Wrong


def rewritten(measured):
    """Say that who has arrived by now was always there."""
    return {"arrived_at": np.full_like(measured.arrived_at, measured.arrived_veh)}


def half_the_wait(measured):
    return {"wait_veh_s": measured.wait_veh_s // 2, "arrived_wait_veh_s": 0}


def padded(observation):
    queue_veh = observation.queue_veh
    return {"queue_veh": np.append(queue_veh, queue_veh[:, :1], axis=1)}


def broken(self, phases):
    if self.state.counters[TIME] >= 30:
        raise ValueError("a wheel came off")
    return QueueSimulator.advance(self, phases)


def another_phase(self, phases):
    self._checked(phases)
    return QueueSimulator.advance(self, (phases + 1) % 8)


def at_once(self, phases):
    observation = QueueSimulator.advance(self, phases)
    left = self.horizon_s > self.state.counters[TIME]
    return QueueSimulator.advance(self, phases) if left else observation


def started(self, vehicles, seed=0):
    QueueSimulator.reset(self, vehicles)
    return QueueSimulator.advance(self, np.zeros(2, np.int32))


def changed_phases(self, phases):
    observation = QueueSimulator.advance(self, phases)
    phases[:] = 0
    return observation


def changed_vehicles(self, vehicles, seed=0):
    vehicles.depart_s[:] -= vehicles.depart_s.min()
    return QueueSimulator.reset(self, vehicles)


def live(self, *seen):
    observation = QueueSimulator._observe(self, *seen)
    return replace(observation, queue_veh=self.state.queue_veh)


def one_record(self):
    measured = QueueSimulator.measures(self)
    self.record = getattr(self, "record", np.zeros(self.horizon_s, np.int32))
    self.record[: measured.time_s] = measured.queued_at
    return replace(measured, queued_at=self.record[: measured.time_s])


def of_numpy(self, phases):
    np.random.random()
    return QueueSimulator.advance(self, phases)


class Unlucky(QueueSimulator):
    """Now and then a phase is not changed; every simulator has its own luck."""

    made = 0

    def __init__(self):
        super().__init__(SMALL)
        Unlucky.made += 1
        self.luck = stream(Unlucky.made, "luck")

    def advance(self, phases):
        shown = self.state.phase
        stays = (self.luck.random(shown.size) < 0.2) & (shown >= 0)
        return super().advance(np.where(stays, shown, self._checked(phases)))


class NeverForgets(QueueSimulator):
    """Counts visits of all runs."""

    before = last = 0

    def __init__(self):
        super().__init__(SMALL)

    def reset(self, vehicles, seed=0):
        self.before += self.last
        return super().reset(vehicles, seed)

    def measures(self):
        measured = super().measures()
        self.last = measured.visits
        return replace(measured, visits=measured.visits + self.before)


def clipped(self, phases):
    return QueueSimulator.advance(self, np.resize(np.clip(phases, 0, 7), 2).astype(np.int32))


def unclear(self, phases):
    return QueueSimulator.advance(self, np.arange(8, dtype=np.int32)[phases])


def too_late(self, phases):
    try:
        return QueueSimulator.advance(self, phases)
    except InputError:
        self.state.counters[VISITS] += 1
        raise


ONLY_ONE = QueueSimulator(SMALL)
RULE = SimulatorRule
WRONG = [
    (RULE.VERBS, dict, "no reset and no advance and no measures and no scenario"),
    (RULE.VERBS, small(measures=None), "no measures"),
    (RULE.FRESH, lambda: ONLY_ONE, "the same object twice"),
    (RULE.FRESH, ONLY_ONE, "not callable"),
    (RULE.RUNS, small(advance=broken), "decision 4 (30 s), the first run on grid:1x2"),
    (RULE.BEGIN, small(reset=started), "10 s"),
    (RULE.BEGIN, shows(lambda o: {"phase": np.maximum(o.phase, 0)}), "-1 everywhere"),
    (RULE.BEGIN, shows(lambda o: {"queue_veh": o.queue_veh + 1}), "queue_veh with [1]"),
    (RULE.OBSERVATION, small(_observe=lambda self, *seen: {}), "a dict"),
    (RULE.OBSERVATION, shows(lambda o: {"queue_veh": o.queue_veh.astype(int)}), "type int64"),
    (RULE.OBSERVATION, shows(padded), "shape (2, 13)"),
    (RULE.OBSERVATION, shows(lambda o: {"phase": o.phase.tolist()}), "phase is a list"),
    (RULE.OBSERVATION, shows(lambda o: {"queue_veh": -o.queue_veh}), "0 or more"),
    (RULE.TIME, small(advance=at_once), "found:    20 s\n  expected: 10 s"),
    (RULE.TIME, shows(lambda o: {"time_s": -(-o.time_s // 10) * 10}), "210 s"),
    (RULE.SIGNALS, small(advance=another_phase), "as asked for"),
    (
        RULE.SIGNALS,
        shows(lambda o: {"phase_elapsed_s": o.phase_elapsed_s + o.time_s}),
        "has been green for 20 s\n  expected: at most 10 s",
    ),
    (RULE.MEASURES, small(measures=lambda self: None), "a NoneType"),
    (RULE.MEASURES, counts(lambda m: {"time_s": m.time_s + 1}), "time_s = 1"),
    (RULE.MEASURES, counts(lambda m: {"wait_veh_s": m.wait_veh_s + 1}), "the sum of queued_at"),
    (RULE.MEASURES, counts(half_the_wait), "the sum of queued_at"),
    (RULE.MEASURES, counts(lambda m: {"queued_at": m.queued_at[1:]}), "one number per second"),
    (RULE.MEASURES, counts(lambda m: {"arrived_veh": 0}), "the last of arrived_at"),
    (RULE.MEASURES, counts(lambda m: {"travel_veh_s": m.wait_veh_s - 1}), "travel_veh_s"),
    (RULE.MEASURES, counts(lambda m: {"visits": 1000 - m.time_s}), "visits fell from 1000 to 990"),
    (RULE.MEASURES, counts(rewritten), "the past changed"),
    (RULE.CONSERVATION, counts(lambda m: {"spawned_veh": 500}), "spawned_veh = 500"),
    (RULE.CONSERVATION, shows(lambda o: {"queue_veh": o.queue_veh * 2}), "more than there can be"),
    (RULE.INPUTS, small(advance=changed_phases), "it changed phases["),
    (RULE.INPUTS, small(reset=changed_vehicles), "it changed vehicles.depart_s[0]"),
    (RULE.SNAPSHOT, small(_observe=live), "later calls changed observation.queue_veh"),
    (RULE.SNAPSHOT, small(measures=one_record), "later calls changed measures().queued_at"),
    (RULE.REPEAT, Unlucky, "as in the first run"),
    (RULE.REPEAT, small(advance=of_numpy), "the global random numbers"),
    (RULE.RESET, NeverForgets, "measures().visits"),
    (RULE.REFUSAL, small(advance=clipped), "no error"),
    (RULE.REFUSAL, small(advance=unclear), "IndexError"),
    (RULE.REFUSAL, small(advance=too_late), "a run with wrong phases in between"),
    (
        RULE.RED,
        lays_out(served=np.ones_like),
        "that all meet red on grid:1x2\n  found:    72 arrived",
    ),
    (
        RULE.RED,
        lays_out(unsignalled=np.ones_like),
        "that all meet red on grid:1x2\n  found:    72 arrived",
    ),
    (RULE.GREEN, lays_out(served=np.zeros_like), "0 arrived"),
]


@pytest.mark.parametrize(("rule", "make", "says"), WRONG)
def test_a_wrong_simulator_is_caught(rule, make, says):
    with pytest.raises(ConformanceError) as caught:
        check_simulator(make)
    assert caught.value.rule is rule, caught.value
    assert says in str(caught.value)


def test_every_rule_has_a_wrong_simulator():
    assert {rule for rule, _, _ in WRONG} == set(SimulatorRule)
