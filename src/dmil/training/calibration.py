"""From one run of SUMO to the numbers that the queue simulator should use."""

from __future__ import annotations

import math
import tempfile
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from dmil.arrays import BoolArray, FloatArray, LongArray
from dmil.controllers import make_controller
from dmil.controllers.protocol import RunContext
from dmil.demand import Vehicles
from dmil.errors import InputError
from dmil.scenarios import Scenario
from dmil.scenarios.calibration import Calibration, digest_of
from dmil.seeding import stream
from dmil.simulation.measures import Measures
from dmil.simulation.protocol import Simulator
from dmil.simulation.sumo import SumoSimulator
from dmil.simulation.sumo.approaches import RouteGeometry, build_ways
from dmil.simulation.sumo.survey import Survey, SurveyFiles
from dmil.training.phases import vehicles_of_seed

SEED = 7_000_000
"""Seed of the run that is measured: far from those of tests."""
OWN_PROGRAM, LIKE_THE_PROGRAM, WITHOUT_PROGRAM = "program", "fixed-cycle", "max-pressure"
HELD_UP_S = 5.0
"""A vehicle that comes to a stop line later than this after free flow stood in a queue."""
SATURATED_FROM = 4
"""Headways are those of saturation from this vehicle on, the first is 0 (as in field studies)."""
LONGEST_HEADWAY_S = 5.0
"""A longer gap is no headway of a queue that discharges."""
FEWEST = 20
"""With fewer headways of saturation, those of earlier vehicles are taken, too."""
GREEN_SINCE_S = 8
"""Who crosses so long after the beginning of green did not brake for red."""
FREE_GAP_S = 4.0
"""Who crosses so long after another did not follow a queue."""
START_WAVE_VEH_PER_S = 1.0
"""A driver follows the one before after a second: SUMO's tau, its default as in all of RESCO."""
FEWEST_PASSAGES = 3
"""With fewer undisturbed vehicles a link's time is not measured."""
STUCK_S = 60.0
"""Who needs longer than this on a link beyond free flow stood in a queue that spilled back."""
TYPICAL = 0.75
"""Part of these, the quickest, that its time is the mean of: others stopped after all."""
ENTRY_LATE_S = 10.0
"""Who enters the network later than this after the wish waited for room, and does not count."""


def calibrate(scenario: Scenario, seed: int = SEED) -> Calibration:
    """Measure in one run of SUMO what the queue simulator should use (ours).

    The network's own program drives the signals: its greens are long, and queues stand long enough
    to discharge at saturation flow. Where programs adapt to the traffic, a fixed cycle of the same
    greens does, and where there is none, max-pressure.

    Parameters
    ----------
    scenario
        What to simulate.
    seed
        Of demand and of chance in SUMO; keep it apart from those of tests.

    Raises
    ------
    InputError
        If no vehicle crossed a stop line in that run.
    MissingExtraError
        If SUMO is not installed.
    """
    vehicles = vehicles_of_seed(scenario, seed)
    with tempfile.TemporaryDirectory(prefix="dmil-survey-") as folder:
        files = SurveyFiles(scenario.network, Path(folder))
        simulator = SumoSimulator(scenario, further_options=files.options)
        try:
            controller = _drive(simulator, scenario, vehicles, seed)
            measures = simulator.measures()
            survey = files.read(vehicles, scenario.horizon_s)
        finally:
            simulator.close()
    passages = Passages(scenario, vehicles, survey)
    headway_s, lost_s, headways = discharge(passages)
    time_s, measured = link_times(passages)
    free_s = np.minimum(free_times(passages, measures), time_s)
    return Calibration(
        scenario=scenario.name,
        links_digest=digest_of(scenario.network),
        controller=controller,
        seed=seed,
        saturation_flow_veh_per_s=round(1 / headway_s, 4),
        startup_lost_s=max(0, round(lost_s)),
        start_wave_veh_per_s=START_WAVE_VEH_PER_S,
        link_time_s=tuple(np.round(time_s, 2).tolist()),
        link_free_s=tuple(np.round(free_s, 2).tolist()),
        headways=headways,
        passages=measured,
    )


def _drive(simulator: Simulator, scenario: Scenario, vehicles: Vehicles, seed: int) -> str:
    """Run to the horizon; return who drove."""
    network = scenario.network
    programs = [item.program for item in network.intersections]
    if all(program and not program.adaptive for program in programs):
        name = OWN_PROGRAM
    else:
        name = LIKE_THE_PROGRAM if any(programs) else WITHOUT_PROGRAM
    observation = simulator.reset(vehicles, seed)
    controller = make_controller(name)
    rng = stream(seed, "exploration")
    controller.reset(RunContext(network, scenario.timing, rng, vehicles, scenario.dynamics))
    while observation.time_s < simulator.horizon_s:
        observation = simulator.advance(controller.decide(observation, None))
    return name


@dataclass(frozen=True)
class Passages:
    """Every link of every journey in a run: when it was reached, how long it took.

    Parameters
    ----------
    scenario, vehicles, survey
        The run.
    """

    scenario: Scenario
    vehicles: Vehicles
    survey: Survey

    @cached_property
    def ways(self) -> RouteGeometry:
        """What comes next on the routes."""
        return build_ways(self.scenario.network, self.vehicles)

    @cached_property
    def first(self) -> BoolArray:
        """Whether a place begins a journey."""
        first = np.zeros(self.vehicles.route_links.size, np.bool_)
        first[self.vehicles.route_offset[:-1]] = True
        return first

    @cached_property
    def reached_s(self) -> FloatArray:
        """When the link before a place was left; of the first link when the journey should begin.

        That SUMO's vehicles enter one after the other counts as slow driving, since those of the
        queue simulator enter at once where there is room.
        """
        reached_s = np.roll(self.survey.left_s, 1)
        depart_s = self.vehicles.depart_s.astype(np.float64)
        soon = self.survey.entered_s - depart_s <= ENTRY_LATE_S
        reached_s[self.vehicles.route_offset[:-1]] = np.where(soon, depart_s, np.nan)
        return reached_s

    @cached_property
    def free_s(self) -> FloatArray:
        """Time of free flow of a place's link."""
        flow_s: FloatArray = self.scenario.network.free_flow_time_s[self.vehicles.route_links]
        return flow_s

    @cached_property
    def leg_begin(self) -> LongArray:
        """Place at which the leg of a place begins: behind the last stop line with signals."""
        begins = self.first.copy()
        begins[1:] |= self.governed[:-1]
        return np.maximum.accumulate(np.where(begins, np.arange(begins.size), 0))

    @cached_property
    def governed(self) -> BoolArray:
        """Whether a place's link ends at signals that the journey crosses."""
        return self.ways.own & (self.ways.movement >= 0)

    @cached_property
    def crossings(self) -> LongArray:
        """Places whose stop line was crossed, by lane and then time."""
        seen = np.flatnonzero(self.governed & (self.survey.lane >= 0))
        return seen[np.lexsort((self.survey.crossed_s[seen], self.survey.lane[seen]))]

    @cached_property
    def delay_s(self) -> FloatArray:
        """Of every crossing, the time from the last stop line on beyond that of free flow."""
        places, begin = self.crossings, self.leg_begin[self.crossings]
        driven_s = np.concatenate([[0.0], np.cumsum(self.free_s)])
        spent_s = self.survey.crossed_s[places] - self.reached_s[begin]
        delay_s: FloatArray = spent_s - (driven_s[places + 1] - driven_s[begin])
        return delay_s

    @cached_property
    def green_from_s(self) -> LongArray:
        """Of every crossing, since when its movement had green; a yellow belongs to the green."""
        green = self.survey.green
        began = green.copy()
        began[1:] &= ~green[:-1]
        seconds = np.arange(len(green))[:, None, None]
        since_s = np.maximum.accumulate(np.where(began, seconds, 0), axis=0)
        movement = self.ways.movement[self.crossings]
        second = self.survey.crossed_s[self.crossings].astype(np.int64)
        second = np.clip(second, 0, len(green) - 1)
        found: LongArray = since_s[second, movement // green.shape[2], movement % green.shape[2]]
        return found


def discharge(passages: Passages) -> tuple[float, float, int]:
    """Return how queues discharge (headways from the fifth vehicle on: field practice).

    Movements that give way are left out: their gaps are those of the others' traffic.

    Returns
    -------
    headway_s: float
        Mean headway at saturation on one lane.
    lost_s: float
        Time of green before vehicles went, had all gone with that headway.
    headways: int
        How many were measured.

    Raises
    ------
    InputError
        If there were none.
    """
    places, since_s = passages.crossings, passages.green_from_s
    lane, crossed_s = passages.survey.lane[places], passages.survey.crossed_s[places]
    queued = (passages.delay_s >= HELD_UP_S) & ~_gives_way(passages)[places]
    follows = np.zeros(places.size, np.bool_)
    follows[1:] = (lane[1:] == lane[:-1]) & (since_s[1:] == since_s[:-1])
    gap_s = np.diff(crossed_s, prepend=np.nan)
    begins = np.flatnonzero(~follows)
    rank = np.arange(places.size) - begins[np.cumsum(~follows) - 1]
    measured = follows & queued & np.roll(queued, 1) & (gap_s < LONGEST_HEADWAY_S)
    leads = ~follows & queued & (crossed_s - since_s < LONGEST_HEADWAY_S)
    for saturated_from in range(SATURATED_FROM, 0, -1):
        saturated = measured & (rank >= saturated_from)
        if saturated.sum() >= FEWEST:
            break
    if not saturated.any() or not leads.any():
        raise InputError(
            "no queue discharged behind another vehicle in the run that was measured",
            where=passages.scenario.name,
            expected="queues of two vehicles and more",
            mend="measure with more demand (--load) or a longer run (--steps)",
        )
    headway_s = float(gap_s[saturated].mean())
    earlier_s = [gap_s[measured & (rank == place)] for place in range(1, saturated_from)]
    late_s = sum(float((gaps_s - headway_s).mean()) for gaps_s in earlier_s if gaps_s.size)
    lost_s = float((crossed_s - since_s)[leads].mean()) + late_s
    return headway_s, lost_s, int(measured.sum())


def link_times(passages: Passages) -> tuple[FloatArray, int]:
    """Return the time of an undisturbed vehicle on every link: (links,) float64 (ours).

    Undisturbed is who, at the next stop line with signals, neither braked for red nor followed a
    queue. The mean of the quicker ones counts, with what they wait at junctions without signals:
    among the others are those that stopped in spite of it, such as for a gap, which is the queue
    simulator's matter. Links with few vehicles get their time of free flow and what others need
    more, in the median.

    Returns
    -------
    time_s: (links,) float64
    measured: int
        Passages that it comes from.
    """
    links = passages.vehicles.route_links
    spent_s = passages.survey.left_s - passages.reached_s
    # A vehicle that has not left a link has no time, which is not less than any other.
    free = _undisturbed(passages) & (spent_s <= passages.free_s + STUCK_S)
    time_s = np.full(len(passages.scenario.network.links), np.nan)
    order = np.flatnonzero(free)
    order = order[np.argsort(links[order], kind="stable")]
    found, starts = np.unique(links[order], return_index=True)
    for link, places in zip(found, np.split(order, starts[1:]), strict=True):
        if places.size >= FEWEST_PASSAGES:
            lower = np.sort(spent_s[places])[: math.ceil(places.size * TYPICAL)]
            time_s[link] = lower.mean()
    flow_s = passages.scenario.network.free_flow_time_s
    known = ~np.isnan(time_s)
    if known.any():
        late_s = float(np.median((time_s - flow_s)[known]))
        time_s = np.where(known, time_s, flow_s + late_s)
    else:
        time_s = flow_s.copy()
    return np.maximum(time_s, 0.0), int(free.sum())


def free_times(passages: Passages, measures: Measures) -> FloatArray:
    """Return the time on every link that does not count as lost in SUMO: (links,) float64 (ours).

    It is that of free flow and an equal part for each crossing of a junction, such that all
    journeys together are as long as SUMO's without what these lost.
    """
    links = passages.vehicles.route_links
    done = ~np.isnan(passages.survey.left_s)
    driving_s = measures.travel_veh_s - measures.departure_delay_veh_s - measures.time_loss_veh_s
    flow_s = passages.scenario.network.free_flow_time_s
    under_way = ~done & ~np.isnan(passages.reached_s)
    known_s = float(flow_s[links[done]].sum() + flow_s[links[under_way]].sum() / 2)
    crossings = int((done & ~passages.first).sum())
    return flow_s + max(0.0, driving_s - known_s) / max(crossings, 1)


def _undisturbed(passages: Passages) -> BoolArray:
    """Tell of every place whether its leg ends without a queue; those out of the network all do."""
    places = passages.crossings
    crossed_s, lane = passages.survey.crossed_s[places], passages.survey.lane[places]
    gap_s = np.diff(crossed_s, prepend=-np.inf)
    gap_s[1:][lane[1:] != lane[:-1]] = np.inf
    ahead_free = np.roll(passages.delay_s, 1) < HELD_UP_S
    green_s = crossed_s - passages.green_from_s
    alone = (green_s >= GREEN_SINCE_S) & ((gap_s >= FREE_GAP_S) | ahead_free)
    legs = np.zeros(passages.first.size, np.bool_)
    legs[passages.leg_begin[places[alone]]] = True
    out = passages.ways.movement < 0
    result: BoolArray = legs[passages.leg_begin] | out
    return result


def _gives_way(passages: Passages) -> BoolArray:
    """Tell of every place whether its movement gives way to others."""
    intersections = passages.scenario.network.intersections
    width = passages.survey.green.shape[2]
    gives = np.zeros(len(intersections) * width + 1, np.bool_)
    for i, item in enumerate(intersections):
        for j, foes in enumerate(item.gives_way):
            gives[i * width + j] = bool(foes)
    result: BoolArray = gives[passages.ways.movement]
    return result
