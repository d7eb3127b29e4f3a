"""What disturbs a run, and when it is over it."""

import numpy as np

from dmil.demand import DemandLevels
from dmil.scenarios import scenario
from dmil.seeding import stream
from dmil.studies.capacity.disturbed import busy_lane, days_of, recovery_s

MADE = scenario("grid:3x3", horizon_s=3600)
LEVELS = DemandLevels.draw(MADE.demand, MADE.network, 3600, 4.0, stream(0, "demand"))
CALM = np.full(3600, 20)


def disturbed(peak, back_s, end_s=1500):
    """A queue that rises from 900 s on to ``end_s`` and is back linearly ``back_s`` later."""
    course = np.interp(np.arange(3600), [900, end_s, end_s + back_s], [0, peak, 0])
    return CALM + course.round().astype(np.int64)


def test_recovery_is_when_five_minutes_on_average_are_as_before():
    found = recovery_s(disturbed(100, 600), CALM, 1500)
    # Three more than 20 are allowed; the mean of a window that begins at t is below that
    # when what is left of the ramp, (600 - t)² / 12 vehicle-seconds, is 900.
    assert abs(found - (600 - np.sqrt(900 * 12))) < 5


def test_no_disturbance_is_recovered_from_at_once():
    assert recovery_s(CALM, CALM, 1500) == 0
    assert recovery_s(CALM + 2, CALM, 1500) == 0


def test_who_never_recovers_counts_to_the_end():
    assert recovery_s(CALM + 50, CALM, 1500) == 2100
    assert recovery_s(CALM, CALM, 3600) == 0


def test_a_closed_lane_is_one_that_vehicles_drive_in_and_the_same_for_a_seed():
    vehicles = LEVELS.at(2.0)
    lanes = {busy_lane(MADE.network, vehicles, 3600, seed) for seed in range(10)}
    assert len(lanes) > 4
    assert busy_lane(MADE.network, vehicles, 3600, 3) == busy_lane(MADE.network, vehicles, 3600, 3)
    used = {MADE.network.links[link].id for link in np.unique(vehicles.route_links)}
    for each in lanes:
        assert each.link in used and (each.from_s, each.until_s) == (900, 1500)
        assert any(
            each.link == movement.from_link and each.lane in movement.lanes
            for item in MADE.network.intersections
            for movement in item.movements
        )


def test_the_other_day_has_the_routes_of_the_day_and_other_vehicles():
    days = days_of(LEVELS, 2.0, MADE.network, 3600, 0)
    assert len(days.other) == len(days.day) < len(days.surge)
    assert not np.array_equal(days.other.depart_s, days.day.depart_s)
    routes = {tuple(days.day.route(v)) for v in range(len(days.day))}
    assert {tuple(days.other.route(v)) for v in range(len(days.other))} <= routes
    again = days_of(LEVELS, 2.0, MADE.network, 3600, 0)
    assert np.array_equal(again.other.depart_s, days.other.depart_s)
