"""SUMO's flows: when their vehicles depart."""

import numpy as np
import pytest

from dmil.demand.sumo.departures import Drawn, Listed, Turns, Window
from dmil.errors import DemandError
from dmil.seeding import stream
from tests.unit.demand.conftest import NETWORK, kinds

ROUTE = '<route id="r" edges="W0>0,0 0,0>N0"/>'


def flow(attributes, name="f"):
    return f'{ROUTE}<flow id="{name}" route="r" {attributes}/>'


def departures(demand, horizon_s=3600, seed=0):
    return demand.vehicles(NETWORK, horizon_s, stream(seed)).depart_s.tolist()


@pytest.mark.parametrize(
    ("attributes", "expected"),
    [
        ('begin="5" end="25" number="4"', [5, 10, 15, 20]),
        ('begin="0" end="20" period="10"', [0, 10]),
        ('begin="0" end="10" period="3.3"', [0, 4, 7, 10]),
        ('begin="0" period="10" number="3"', [0, 10, 20]),
        ('begin="0" end="3" perHour="3600"', [0, 1, 2]),
        ('begin="0" end="21" vehsPerHour="514.2857142857"', [0, 7, 14]),
        ('end="60" period="0:00:20"', [0, 20, 40]),
        ('begin="190" period="20"', [190]),
        ('begin="5" number="3"', [5, 70, 135]),
    ],
)
def test_departures_at_fixed_times(read, attributes, expected):
    demand = read(flow(attributes), end_s=200)
    assert departures(demand) == expected
    assert (demand.last_departure_s, demand.streams) == (expected[-1], ())


@pytest.mark.parametrize(
    ("attributes", "expected"),
    [
        ('begin="0" end="40" period="7"', [4, 11, 18, 25]),
        ('begin="0" end="40" number="4"', [0, 10, 20]),
        ('begin="begin" end="40" period="20"', [0, 20]),
        ('begin="0" end="13" probability="1"', [0, 1, 2]),
    ],
)
def test_a_flow_that_began_before_goes_on(read, attributes, expected):
    assert departures(read(flow(attributes), begin_s=10)) == expected


def test_a_probability_is_a_coin_in_every_second(read):
    demand = read(flow('begin="100.5" end="2100" probability="0.25"'), begin_s=100)
    found = departures(demand)
    assert len(set(found)) == len(found)
    assert min(found) >= 1 and max(found) < 2000
    assert abs(len(found) - 500) < 5 * np.sqrt(2000 * 0.25 * 0.75)
    assert departures(demand) == found != departures(demand, seed=1)
    assert departures(demand, 50) == [] or max(departures(demand, 50)) < 50
    assert demand.last_departure_s == 1999


def test_an_exponential_period_is_a_poisson_process(read):
    demand = read(flow('begin="0" end="2000" period="exp(0.5)"'))
    found = departures(demand)
    assert abs(len(found) - 1000) < 5 * np.sqrt(1000)
    assert len(set(found)) < len(found)
    assert found == sorted(found)
    assert found[0] > 0 and found[-1] <= 2000
    assert abs(np.mean(found) - 1000) < 5 * 2000 / np.sqrt(12 * len(found))


@pytest.mark.parametrize("spacing", ['period="exp(0.5)"', 'probability="0.5"'])
def test_random_departures_can_end_with_a_number(read, spacing):
    demand = read(flow(f'begin="10" number="400" {spacing}'))
    found = departures(demand)
    assert (len(found), found[0] >= 10) == (400, True)
    assert abs(found[-1] - 810) < 5 * np.sqrt(400 / 0.25)
    assert len(departures(demand, 100)) + demand.vehicles(NETWORK, 100, stream(0)).dropped == 400


def test_flows_outside_the_run_are_left_out(read):
    text = flow('begin="0" end="5" probability="0.5"', "early") + (
        '<flow id="in" route="r" begin="12" end="14" period="1"/>'
        '<flow id="late" route="r" begin="90" end="95" probability="0.5"/>'
        '<flow id="later" route="r" begin="95" period="1"/>'
        '<flow id="none" route="r" begin="96" end="99" number="0"/>'
    )
    demand = read(text, begin_s=10, end_s=20)
    assert departures(demand, 10) == [2, 3]
    assert kinds(demand) == {"before-begin": (1, "early"), "after-end": (1, "late")}


@pytest.mark.parametrize(
    ("attributes", "message"),
    [
        ('begin="5" end="9"', "it does not say how many vehicles depart"),
        ('begin="5" end="9" period="2" number="5"', "it has period, number and end"),
        ('begin="5" end="9" period="2" probability="1"', "it has period and probability"),
        ('begin="20" end="10" period="2"', "it ends at 10 s, before it begins at 20 s"),
        ('begin="5" period="2"', "it has no end, nor has the run"),
        ('begin="5" probability="0.5"', "it has no end, nor has the run"),
        ('end="9" probability="1.5"', "probability is '1.5'; expected a number above 0, at most 1"),
        ('end="9" probability="0"', "probability is '0'"),
        ('end="9" period="exp(x)"', r"period is 'exp\(x\)'; expected exp\(rate\)"),
        ('end="9" period="0"', "period is '0'; expected a number above 0"),
        ('end="9" perHour="0"', "perHour is '0'"),
        ('end="9" perHour="many"', "perHour is 'many'"),
        ('end="9" number="1.5"', "number is '1.5'; expected a whole number"),
        ('end="9" number="-1"', "number is '-1'"),
        ('end="9" number="1e12"', "number is '1e12'"),
        ('end="1e8" period="0.001"', "it stands for 1e.11 vehicles; expected at most 10,000,000"),
        ('end="1e8" period="exp(1000)"', "it stands for 1e.11 vehicles"),
        ('end="soon" number="1"', "end is 'soon'"),
    ],
)
def test_a_contradiction_is_named(read, attributes, message):
    with pytest.raises(DemandError, match=f"flow 'f': {message}"):
        read(flow(attributes))


def test_a_flow_may_have_the_id_of_a_vehicle_but_not_of_another_flow(read):
    route = '<route edges="ACROSS"/>'
    vehicle = f'<vehicle id="7" depart="0">{route}</vehicle>'
    flow = f'<flow id="7" begin="0" end="20" number="2">{route}</flow>'
    assert len(read(vehicle + flow).recorded.recorded.depart_s) == 3
    with pytest.raises(DemandError, match="there is another flow of this id"):
        read(flow + flow)


def test_kinds_take_turns_as_often_as_their_shares_say_at_any_time():
    turns = Turns((0.5, 0.375, 0.125), Window(0.0, None))
    driven = np.zeros(3)
    for vehicle in range(1, 41):
        parts = turns.share_out(Listed(np.array([float(vehicle)])))
        driven += [len(part.depart_s) for part in parts]
        assert (np.abs(driven - vehicle * np.array((0.5, 0.375, 0.125))) < 1).all()
    assert driven.tolist() == [20, 15, 5]


def test_a_number_drawn_at_random_times_is_shared_out_in_turn():
    drawn = Drawn(0.0, 100.0, 0.4, each_second=False, number=8)
    half, rest, nobody = Turns((0.5, 0.5, 0.0), Window(0.0, None)).share_out(drawn)
    assert (half.number, rest.number, half.rate_per_s) == (4, 4, 0.2)
    assert nobody.mean_veh == 0


def test_in_a_run_kinds_are_as_often_as_their_shares_say_whatever_comes_after_it():
    turns = Turns((0.75, 0.25), Window(0.0, 100.0))
    driven = np.zeros(2)
    for first_s in range(10):
        parts = turns.share_out(Listed(np.arange(first_s, 9000.0, 31.0)))
        driven += [(part.depart_s < 100).sum() for part in parts]
    assert abs(driven[1] - driven.sum() / 4) < 1
