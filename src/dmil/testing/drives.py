"""Runs of a simulator under watch: what it shows, what it counts, and what it leaves alone."""

from __future__ import annotations

import copy
from collections.abc import Callable
from enum import StrEnum

import numpy as np
import numpy.typing as npt

from dmil.demand import Vehicles
from dmil.simulation import Measures, Observation, Simulator
from dmil.testing.conformance import Witness, array_in_words

PhaseArray = npt.NDArray[np.int32]
Seen = tuple[Observation, Measures]

GROWING = (
    "spawned_veh",
    "arrived_veh",
    "wait_veh_s",
    "visits",
    "arrived_wait_veh_s",
    "travel_veh_s",
    "time_loss_veh_s",
    "departure_delay_veh_s",
    "stops",
    "overruled",
)
"""Measures that only grow during a run."""


class SimulatorRule(StrEnum):
    """What every simulator keeps."""

    VERBS = "it has reset, advance, measures, scenario, network, decision_interval_s and horizon_s"
    FRESH = "every call of make gives a new simulator"
    RUNS = "reset, advance and measures work from 0 s to the horizon"
    BEGIN = "a run begins at 0 s, with an empty network and no phase shown"
    OBSERVATION = "observations are arrays of the network's shape and their type, none negative"
    TIME = "advance moves the time on by one decision interval, at most to the horizon"
    SIGNALS = "the phase shown is the one that was asked for, or the one before"
    MEASURES = "measures only grow, fit together, and are there for every second so far"
    CONSERVATION = "vehicles are neither lost nor doubled"
    INPUTS = "it does not change the vehicles or phases that it is given"
    SNAPSHOT = "observations and measures that were returned do not change later"
    REPEAT = "the same vehicles and phases give the same run"
    RESET = "after a reset nothing is left of the run before"
    REFUSAL = "a phase that does not exist raises an InputError and changes nothing"
    RED = "nobody crosses on red"
    GREEN = "who has green all the way arrives"


def made(make: Callable[[], object], witness: Witness) -> Simulator:
    """Make a simulator and check its verbs."""
    with witness.no_exception(SimulatorRule.FRESH, "make()"):
        simulator = make()
    witness.subject = type(simulator).__name__
    verbs = ("reset", "advance", "measures")
    data = ("scenario", "network", "decision_interval_s", "horizon_s")
    missing = [name for name in verbs if not callable(getattr(simulator, name, None))]
    missing += [name for name in data if not hasattr(simulator, name)]
    witness.expect(
        not missing,
        SimulatorRule.VERBS,
        f"no {' and no '.join(missing)}",
        f"the methods {', '.join(verbs)} and the attributes {', '.join(data)}",
    )
    return simulator  # type: ignore[return-value]


class Drive:
    """One run, in which every step is checked; its label says in errors which it is."""

    def __init__(
        self, simulator: Simulator, witness: Witness, vehicles: Vehicles, label: str
    ) -> None:
        self._simulator, self._witness, self._vehicles = simulator, witness, vehicles
        self._label = label
        self._place("reset")
        with (
            witness.no_exception(SimulatorRule.RUNS, "reset and measures"),
            witness.no_global_chance(SimulatorRule.REPEAT),
            witness.no_change(SimulatorRule.INPUTS, vehicles=vehicles),
        ):
            shown, counted = simulator.reset(vehicles, 0), simulator.measures()
        self._returned: list[Seen] = []
        self.seen: list[Seen] = []
        self._keep(shown, counted)
        self._check_begin(shown)
        self._check_observation(shown)
        self._check_measures(shown, counted)

    def to_the_end(self, phases: PhaseArray) -> Drive:
        """Show (decisions, intersections) int32 phases one decision after the other."""
        for choice in phases:
            self.advance(choice)
        return self

    def advance(self, phases: PhaseArray) -> None:
        """Show phases for one interval."""
        witness, simulator = self._witness, self._simulator
        before, counted_before = self.seen[-1]
        self._place(f"decision {len(self.seen)} ({before.time_s} s)")
        with (
            witness.no_exception(SimulatorRule.RUNS, "advance and measures"),
            witness.no_global_chance(SimulatorRule.REPEAT),
            witness.no_change(SimulatorRule.INPUTS, phases=phases, vehicles=self._vehicles),
        ):
            after, counted = simulator.advance(phases), simulator.measures()
            counted_again = simulator.measures()
        self._keep(after, counted)
        self._check_observation(after)
        self._check_signals(before, phases, after)
        end_s = min(before.time_s + simulator.decision_interval_s, simulator.horizon_s)
        witness.expect(after.time_s == end_s, SimulatorRule.TIME, f"{after.time_s} s", f"{end_s} s")
        self._check_measures(after, counted)
        self._check_growth(counted_before, counted)
        witness.expect_same(SimulatorRule.MEASURES, counted, counted_again, "measures()")

    def expect_equal(self, model: Drive, rule: SimulatorRule) -> None:
        """Check that everything seen is as it was in another run."""
        self._expect_same(rule, model.seen, self.seen, "{}", f"as in {model._label}")

    def expect_untouched(self) -> None:
        """Check that what was returned is as it was when it was returned."""
        found, expected = "later calls changed {}", "copies of what the simulator works on"
        self._expect_same(SimulatorRule.SNAPSHOT, self.seen, self._returned, found, expected)

    def _expect_same(
        self, rule: SimulatorRule, before: list[Seen], now: list[Seen], found: str, expected: str
    ) -> None:
        for k, (seen, seen_now) in enumerate(zip(before, now, strict=True)):
            self._place(f"after {k} decisions ({seen[0].time_s} s)")
            for one, other, name in zip(seen, seen_now, ("observation", "measures()"), strict=True):
                self._witness.expect_same(rule, one, other, name, found, expected)

    def _place(self, point: str) -> None:
        self._witness.where = f"{point}, {self._label} on {self._simulator.network.name}"

    def _keep(self, shown: object, counted: object) -> None:
        for found, kind in ((shown, Observation), (counted, Measures)):
            rule = SimulatorRule.MEASURES if kind is Measures else SimulatorRule.OBSERVATION
            self._witness.expect(
                isinstance(found, kind),
                rule,
                f"a {type(found).__name__}",
                f"a dmil.simulation.{kind.__name__}",
            )
        pair: Seen = (shown, counted)  # type: ignore[assignment]
        self._returned.append(pair)
        self.seen.append(copy.deepcopy(pair))

    def _check_begin(self, shown: Observation) -> None:
        rule, expect = SimulatorRule.BEGIN, self._witness.expect
        expect(shown.time_s == 0, rule, f"{shown.time_s} s", "0 s")
        empty = ("queue_veh", 0), ("approaching_veh", 0), ("waiting_veh", 0), ("phase", -1)
        for name, value in empty:
            found = np.unique(getattr(shown, name)).tolist()
            expect(found == [value], rule, f"{name} with {found}", f"{value} everywhere")

    def _check_observation(self, shown: Observation) -> None:
        rule, expect = SimulatorRule.OBSERVATION, self._witness.expect
        intersections = self._simulator.network.intersections
        own = np.array([len(item.movements) for item in intersections])
        shapes = {
            "queue_veh": (own.size, int(own.max())),
            "approaching_veh": (own.size, int(own.max())),
            "phase": own.shape,
            "phase_elapsed_s": own.shape,
            "waiting_veh": (own.size, int(own.max())),
        }
        for name, shape in shapes.items():
            kind = np.dtype(np.float64 if name == "waiting_veh" else np.int32)
            array: object = getattr(shown, name)
            if not (isinstance(array, np.ndarray) and array.shape == shape and array.dtype == kind):
                self._witness.fail(
                    rule,
                    f"{name} is {array_in_words(array)}",
                    f"an array of shape {shape} and type {kind}",
                )
            least = -1 if name == "phase" else 0
            expect(array.min() >= least, rule, f"{name} with {array.min()}", f"{least} or more")
            if array.ndim == 2:
                padding = np.arange(shape[1]) >= own[:, None]
                expect(
                    not array[padding].any(),
                    rule,
                    f"{name} with vehicles past an intersection's own movements",
                    "0 there",
                )

    def _check_signals(self, before: Observation, phases: PhaseArray, after: Observation) -> None:
        asked = (after.phase == phases) | ((after.phase == before.phase) & (before.phase >= 0))
        i = int(asked.argmin())
        self._witness.expect(
            asked.all(),
            SimulatorRule.SIGNALS,
            self._shown(i, f"shows phase {after.phase[i]}"),
            f"phase {phases[i]} as asked for, or phase {before.phase[i]} as before",
        )
        interval_s = after.time_s - before.time_s
        most_s = np.where(
            after.phase == before.phase, before.phase_elapsed_s + interval_s, interval_s
        )
        i = int((most_s - after.phase_elapsed_s).argmin())
        self._witness.expect(
            (after.phase_elapsed_s <= most_s).all(),
            SimulatorRule.SIGNALS,
            self._shown(i, f"has been green for {after.phase_elapsed_s[i]} s"),
            f"at most {most_s[i]} s",
        )

    def _shown(self, i: int, what: str) -> str:
        return f"intersection '{self._simulator.network.intersections[i].id}' {what}"

    def _check_measures(self, shown: Observation, counted: Measures) -> None:
        time_s, rule, expect = shown.time_s, SimulatorRule.MEASURES, self._witness.expect
        expect(counted.time_s == time_s, rule, f"time_s = {counted.time_s}", f"{time_s}")
        for name in ("arrived_at", "queued_at"):
            array = getattr(counted, name)
            expect(
                isinstance(array, np.ndarray) and array.shape == (time_s,),
                rule,
                f"{name} is {array_in_words(array)}",
                f"an array of shape ({time_s},), one number per second",
            )
        arrived = counted.arrived_at[-1] if time_s else 0
        expect(
            counted.arrived_veh == arrived,
            rule,
            f"arrived_veh = {counted.arrived_veh}",
            f"{arrived}, the last of arrived_at",
        )
        wait_veh_s, queued = counted.wait_veh_s, counted.queued_at.sum()
        unseen_veh_s = self._unseen_veh_s(counted)
        expect(
            abs(wait_veh_s - queued) <= unseen_veh_s,
            rule,
            f"wait_veh_s = {wait_veh_s}",
            f"{queued}, the sum of queued_at (or {unseen_veh_s} more or less)",
        )
        for name, found, most, meaning in (
            ("arrived_wait_veh_s", counted.arrived_wait_veh_s, counted.wait_veh_s, "wait_veh_s"),
            ("wait_veh_s", counted.wait_veh_s, counted.travel_veh_s, "travel_veh_s"),
        ):
            expect(found <= most, rule, f"{name} = {found}", f"at most {most}, {meaning}")
        self._check_conservation(shown, counted)

    def _unseen_veh_s(self, counted: Measures) -> float:
        """Return how far queues that are only seen at decisions may be from the waiting time.

        A simulator may interpolate ``queued_at`` in between. Every halt, those under way included,
        is then known to less than one decision interval; besides, numbers of vehicles are rounded.
        """
        halts = counted.stops + int(counted.queued_at[-1:].sum())
        return halts * self._simulator.decision_interval_s + counted.time_s / 2

    def _check_conservation(self, shown: Observation, counted: Measures) -> None:
        rule, expect = SimulatorRule.CONSERVATION, self._witness.expect
        departed = int(np.searchsorted(self._vehicles.depart_s, shown.time_s))
        spawned = counted.spawned_veh
        expect(
            spawned == departed,
            rule,
            f"spawned_veh = {spawned}",
            f"{departed}, the vehicles that depart before {shown.time_s} s",
        )
        underway = spawned - counted.arrived_veh
        queued, approaching = int(shown.queue_veh.sum()), int(shown.approaching_veh.sum())
        for name, found in (
            ("arrived_veh", counted.arrived_veh - spawned),
            ("queued and approaching vehicles", queued + approaching - underway),
            ("the last of queued_at", int(counted.queued_at[-1:].sum()) - underway),
        ):
            expect(
                found <= 0,
                rule,
                f"{name}: {found} more than there can be",
                f"no more than the {spawned} spawned vehicles, "
                f"of which {counted.arrived_veh} have arrived",
            )
        waiting = int(counted.queued_at[-1:].sum())
        expect(
            queued <= waiting,
            rule,
            f"queue_veh with {queued} vehicles",
            f"at most {waiting}, the last of queued_at",
        )

    def _check_growth(self, before: Measures, after: Measures) -> None:
        rule, expect = SimulatorRule.MEASURES, self._witness.expect
        for name in GROWING:
            old, new = getattr(before, name), getattr(after, name)
            expect(new >= old, rule, f"{name} fell from {old} to {new}", "it never falls")
        falls = np.flatnonzero(np.diff(after.arrived_at) < 0)
        expect(not falls.size, rule, f"arrived_at falls after {falls[:1]} s", "it never falls")
        for name in ("arrived_at", "queued_at"):
            old, new = getattr(before, name), getattr(after, name)[: before.time_s]
            told = "the past changed, {}", "the past stays"
            self._witness.expect_same(rule, old, new, name, *told)
