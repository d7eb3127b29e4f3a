"""Demand in place of a scenario's own: what stays, what is refused."""

import json

import pytest
from pydantic import ValidationError

from dmil.demand import CompoundPoissonDemand, FileDemand, PoissonDemand, ProfileDemand
from dmil.errors import InputError
from dmil.network import grid
from dmil.scenarios import scenario
from dmil.scenarios.demand_changes import DemandChanges, changes_of, with_ties
from dmil.scenarios.recipe import GridChanges, ScenarioRecipe
from dmil.seeding import stream
from dmil.training import vehicles_of_seed
from tests.unit.cityflow.conftest import crossing_document

PAPER = {"E": 5.0, "N": 5.0, "W": 10.0, "S": 7.0}
NETWORK = grid(2, 2)


@pytest.fixture
def roadnet_files(tmp_path):
    """A crossing and one recorded vehicle, in CityFlow's format."""
    document, _ = crossing_document()
    flow = [
        {"route": ["E_in", "W_out"], "interval": 1, "startTime": 0, "endTime": 0, "vehicle": {}}
    ]
    paths = tmp_path / "roadnet.json", tmp_path / "flow.json"
    for path, content in zip(paths, (document, flow), strict=True):
        path.write_text(json.dumps(content))
    return paths


def changed(demand=None, **changes):
    return DemandChanges(**changes).applied_to(demand or PoissonDemand(), NETWORK)


def recorded():
    return FileDemand.from_routes(NETWORK, [3.0], [["E0>0,1", "0,1>N1"]])


def test_nothing_given_is_the_same_object():
    demand = recorded()
    assert changed(demand) is demand


def test_compound_arrivals_keep_rates_and_ties():
    assert changed(arrivals="compound") == CompoundPoissonDemand(PAPER, 2.0)
    found = changed(PoissonDemand({"E": 3.0}, "coin"), arrivals="compound", batch_veh=4)
    assert found == CompoundPoissonDemand({"E": 3.0}, 4.0, "coin")
    found = changed(CompoundPoissonDemand(), batch_probability={1: 0.5, 4: 0.5})
    assert found.mean_batch_veh == 2.5
    assert changed(CompoundPoissonDemand(PAPER, 3.0), arrivals="poisson") == PoissonDemand(PAPER)


def test_rates_and_profiles_replace_only_themselves():
    own = ProfileDemand(PoissonDemand(), (0, 60), (1.0, 2.0), "linear")
    found = changed(own, rate_veh_per_min={"E0": 6.0})
    assert found == ProfileDemand(PoissonDemand({"E0": 6.0}), (0, 60), (1.0, 2.0), "linear")
    found = changed(own, profile=[(0, 3.0)])
    assert found == ProfileDemand(PoissonDemand(), [0.0], [3.0], "step")
    assert changed(own, profile_between="step").between == "step"


def test_rates_replace_recorded_vehicles():
    assert changed(recorded(), rate_veh_per_min={"E": 6}) == PoissonDemand({"E": 6.0})


@pytest.mark.parametrize(
    "demand, changes, said",
    [
        (None, {"batch_veh": 3}, r"^demand: batches are given, .*Add --arrivals compound\.$"),
        (None, {"profile_between": "step"}, "^demand.profile_between: 'step' is given, but"),
        (None, {"rate_veh_per_min": {"Q": 1}}, r"^demand\.rate_veh_per_min .*named 'Q'.*E0"),
        (recorded(), {"arrivals": "compound"}, "^demand: arrivals: the vehicles of 'grid:2x2' are"),
        (
            ProfileDemand(ProfileDemand(PoissonDemand(), [0], [1]), [0], [1]),
            {"arrivals": "compound"},
            "^demand: its profile is over a ProfileDemand",
        ),
    ],
)
def test_what_does_not_fit_the_demand_is_refused(demand, changes, said):
    with pytest.raises(InputError, match=said):
        changed(demand, **changes)


@pytest.mark.parametrize(
    "changes, said",
    [
        ({"arrivals": "poisson", "batch_veh": 3}, "arrivals that are compound"),
        ({"batch_veh": 3, "batch_probability": {1: 1.0}}, "not both"),
        ({"batch_veh": 0.5}, "greater than or equal to 1"),
        ({"batch_probability": {1: 0.5}}, "probabilities that sum to 1"),
        ({"rate_veh_per_min": {"E": -1}}, "greater than or equal to 0"),
        ({"rate_veh_per_min": {}}, "vehicles per minute by fringe node or side"),
        ({"profile": [(5, 1)]}, "increasing seconds, the first 0"),
        ({"profile": []}, "at least one"),
        ({"profile": [(0, 1), (0, 2)]}, "increasing seconds"),
    ],
)
def test_wrong_values_are_refused(changes, said):
    with pytest.raises(ValidationError, match=said):
        DemandChanges(**changes)


@pytest.mark.parametrize(
    "demand",
    [
        PoissonDemand({"E": 1.0}),
        CompoundPoissonDemand(PAPER, 3.0),
        CompoundPoissonDemand(PAPER, {1: 0.25, 2: 0.75}),
        ProfileDemand(PoissonDemand(), (0.0, 60.0), (1.0, 2.0), "linear"),
    ],
)
def test_what_a_demand_is_makes_it_again(demand):
    changes = changes_of(demand)
    again = DemandChanges.model_validate_json(changes.model_dump_json())
    found = again.applied_to(PoissonDemand({"W": 9.0}), NETWORK)
    assert changes_of(found) == changes
    first, second = (each.vehicles(NETWORK, 60, stream(1, "demand")) for each in (demand, found))
    assert first.route_links.tobytes() == second.route_links.tobytes()
    assert changes_of(recorded()) == DemandChanges()


@pytest.mark.parametrize(
    "given, left",
    [
        ({"arrivals": "poisson"}, {"arrivals": "poisson", "rate_veh_per_min": {"E": 1.0}}),
        (
            {"batch_probability": {2: 1.0}},
            {
                "arrivals": "compound",
                "rate_veh_per_min": {"E": 1.0},
                "batch_probability": {2: 1.0},
            },
        ),
        (
            {"rate_veh_per_min": {"W": 2.0}},
            {"arrivals": "compound", "batch_veh": 3.0, "rate_veh_per_min": {"W": 2.0}},
        ),
    ],
)
def test_changes_go_over_others(given, left):
    below = DemandChanges(arrivals="compound", batch_veh=3, rate_veh_per_min={"E": 1})
    assert DemandChanges(**given).over(below) == DemandChanges(**left)


def test_a_scenario_takes_ties():
    assert scenario("grid:2x2").demand.ties == "straight"
    assert scenario("grid:2x2", ties="coin").demand == PoissonDemand(ties="coin")
    assert scenario("grid:2x2/time-varying", ties="coin").demand.ties == "coin"
    assert ScenarioRecipe(scenario="grid:2x2", ties="coin").build().demand.ties == "coin"


def test_recorded_vehicles_have_no_ties():
    with pytest.raises(InputError, match=r"^ties: the vehicles of 'grid:2x2' are recorded"):
        with_ties(recorded(), "coin", NETWORK)


def test_the_load_goes_over_the_new_demand():
    recipe = ScenarioRecipe(
        scenario="grid:2x2", load=2.0, demand=DemandChanges(rate_veh_per_min={"E": 6.0})
    )
    assert recipe.build().demand == PoissonDemand({"E": 12.0})


def test_recorded_cities_take_rates_and_then_ties(roadnet_files):
    files = {"roadnet": roadnet_files[0], "flow": roadnet_files[1]}
    with pytest.raises(InputError, match=r"^ties: the vehicles of .* are recorded"):
        ScenarioRecipe(**files, ties="coin").build()
    node = ScenarioRecipe(**files).build().network.fringe[0]
    rates = DemandChanges(rate_veh_per_min={node: 6.0})
    found = ScenarioRecipe(**files, ties="coin", demand=rates).build()
    assert found.demand == PoissonDemand({node: 6.0}, "coin")
    assert len(vehicles_of_seed(found, 0)) > 0


def test_a_recipe_survives_json():
    changes = {"batch_probability": {1: 0.5, 4: 0.5}, "profile": [(0, 1), (60, 2)]}
    recipe = ScenarioRecipe(
        scenario="grid:2x2", ties="coin", demand={"arrivals": "compound", **changes}
    )
    assert ScenarioRecipe(**json.loads(recipe.model_dump_json())) == recipe
    assert ScenarioRecipe.model_validate_json(recipe.model_dump_json()) == recipe


# --- Links of a grid ---------------------------------------------------------------------------


def test_links_of_a_grid_take_as_long_as_is_said():
    network = grid(1, 2, link_time_s=3, entry_link_time_s=2)
    times = {link.id: link.free_flow_time_s for link in network.links}
    assert times["0,0>0,1"] == times["0,1>0,0"] == 3.0
    assert times["E0>0,1"] == times["0,0>W0"] == times["N0>0,0"] == 2.0
    assert grid(1, 2, link_time_s=5, entry_link_time_s=0) == grid(1, 2)


def test_the_recipe_hands_them_on():
    made = ScenarioRecipe(scenario="grid:1x2", grid=GridChanges(link_time_s=7)).build()
    assert made.network.free_flow_time_s.max() == 7.0


@pytest.mark.parametrize("time_s", [-1.0, float("nan"), float("inf")])
@pytest.mark.parametrize("name", ["link_time_s", "entry_link_time_s"])
def test_times_that_are_none_are_refused(name, time_s):
    with pytest.raises(InputError, match=f"^grid: {name} is .*; expected a number of seconds"):
        grid(1, 1, **{name: time_s})
    with pytest.raises(ValidationError):
        GridChanges(**{name: time_s})


def test_only_grids_have_them(roadnet_files):
    said = "^grid: link_time_s: the links of .* have times of their own"
    with pytest.raises(InputError, match=said):
        scenario("resco/cologne1", link_time_s=3)
    files = {"roadnet": roadnet_files[0], "flow": roadnet_files[1]}
    with pytest.raises(InputError, match=said):
        ScenarioRecipe(**files, grid=GridChanges(link_time_s=3)).build()
