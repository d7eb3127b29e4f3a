"""What the study of memories runs, where, and when a learner counts as better."""

import json

import numpy as np
import pytest

from dmil.controllers import CONTROLLERS, make_controller
from dmil.controllers.variants import Variant, parse_variant
from dmil.errors import DivergedError, InputError, UnknownNameError
from dmil.experiments.cells import Cell, city_cells
from dmil.experiments.study import identity_of
from dmil.studies import MemoriesStudy
from dmil.studies.memories import MemoriesStudySettings
from dmil.studies.memories import study as units_module
from dmil.studies.memories.plan import (
    ABLATIONS,
    CONTENDERS,
    DEEP,
    GRID_CELLS,
    ablations,
    cells,
    contenders,
    is_trained,
    options_of,
    units,
)
from dmil.studies.memories.study import decisions_until_better, run_unit
from tests.unit.cityflow.conftest import crossing_document

RULES = ("random", "max-pressure", "longest-queue-first,approaching=true")


@pytest.fixture
def data(tmp_path):
    """A folder with one city of one crossing and two flows, as CityFlow's users keep it."""
    folder = tmp_path / "data" / "cityflow" / "smalltown_1x1"
    folder.mkdir(parents=True)
    vehicle = {"route": ["E_in", "W_out"], "interval": 1, "startTime": 3, "endTime": 3}
    (folder / "roadnet.json").write_text(json.dumps(crossing_document()[0]))
    for name in ("flow.json", "flow_900.json"):
        (folder / name).write_text(json.dumps([vehicle]))
    return tmp_path / "data"


def labels(variants):
    return [each.label for each in variants]


def test_units_are_every_cell_seed_and_controller_that_fit():
    settings = MemoriesStudySettings(
        controllers=("max-pressure", "foresight"), cells=("grid:1x1*3", "grid:3x3"), seeds=2
    )
    plan = units(settings)
    found = [(unit.scenario, unit.load, unit.seed, unit.controller.label) for unit in plan]
    assert found == [
        ("grid:1x1", 3.0, 0, "max-pressure"),
        ("grid:1x1", 3.0, 0, "foresight"),
        ("grid:1x1", 3.0, 1, "max-pressure"),
        ("grid:1x1", 3.0, 1, "foresight"),
        ("grid:3x3", 1.0, 0, "max-pressure"),  # foresight plans for one intersection only
        ("grid:3x3", 1.0, 1, "max-pressure"),
    ]


def test_every_controller_that_makes_sense_is_in_it():
    names = {each.name for each in contenders(MemoriesStudySettings())}
    sumo_only_or_without_meaning_on_grids = {"actuated", "program"}
    assert names == CONTROLLERS.keys() - sumo_only_or_without_meaning_on_grids
    assert set(DEEP) <= names


def test_without_deep_rivals_all_others_stay():
    found = labels(contenders(MemoriesStudySettings(deep=False)))
    assert found == [*(name for name in CONTENDERS if name not in DEEP), *ABLATIONS]


def test_ablations_go_with_the_default_controllers_or_are_named():
    chosen = MemoriesStudySettings(controllers=("factored", "max-pressure"))
    assert ablations(chosen) == []
    assert labels(contenders(chosen)) == ["factored", "max-pressure"]
    named = chosen.model_copy(update={"ablations": ("factored,wave=0",)})
    assert labels(ablations(named)) == ["factored,wave=0"]
    assert contenders(named)[-1].label == "factored,wave=0"
    configuration = identity_of(MemoriesStudy(MemoriesStudySettings()))["configuration"]
    assert configuration["ablations"] == list(ABLATIONS)
    none = MemoriesStudySettings(ablations=("none",), deep=False)
    assert labels(contenders(none)) == [name for name in CONTENDERS if name not in DEEP]
    for label in ABLATIONS:
        variant = parse_variant(label)
        assert variant.label == label
        make_controller(variant.name, variant.options)


def test_the_vehicles_of_a_seed_are_drawn_once():
    cell = Cell("grid:1x1")
    one, again, other = (units_module._vehicles(cell, 300, None, seed) for seed in (4, 4, 5))
    assert one is again
    assert other is not one


def test_a_cell_is_named_by_scenario_and_load():
    for name in (*GRID_CELLS, "cityflow:jinan_3x4#flow.json"):
        assert Cell.parse(name).name == name
    assert Cell.parse("grid:5x5*3.6") == Cell("grid:5x5", 3.6)
    with pytest.raises(InputError, match=r"'grid:5x5\*much'.*SCENARIO\*LOAD"):
        Cell.parse("grid:5x5*much")


def test_every_default_cell_can_be_built():
    for name in GRID_CELLS:
        made = Cell.parse(name).build(600, None)
        assert made.horizon_s == 600
        assert made.timing.decision_interval_s == 10 and made.timing.clearance_s == 0


def test_cities_come_from_the_folder_of_data(data):
    names = city_cells(data)
    assert names == ("cityflow:smalltown_1x1",)
    other = Cell.parse("cityflow:smalltown_1x1#flow_900.json").build(600, data)
    assert other.demand is not None
    assert [cell.name for cell in cells(MemoriesStudySettings(data=data))][-1:] == list(names)
    timing = Cell.parse(names[0]).build(600, data).timing
    assert (timing.decision_interval_s, timing.clearance_s) == (15, 5)
    # Where the files lie does not make it another study.
    one = identity_of(MemoriesStudy(MemoriesStudySettings(data=data)))
    assert one == identity_of(MemoriesStudy(MemoriesStudySettings(data=data / "cityflow")))
    assert one != identity_of(MemoriesStudy(MemoriesStudySettings()))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"cells": ("cityflow:jinan_3x4",)}, "no data folder was given.*--data"),
        ({"cells": ("grid:5x5/unequl",)}, "Did you mean 'unequal'"),
        ({"controllers": ("max-presure",)}, "Did you mean 'max-pressure'"),
        ({"controllers": ("max-pressure,aproaching=true",)}, "Did you mean 'approaching'"),
        ({"reward": "queues"}, "queue"),
        ({"controllers": ("foresight",), "cells": ("grid:1x2",)}, "plans for a single"),
        ({"controllers": ("foresight",), "cells": ("grid:1x2", "grid:1x1")}, None),
        ({"horizon_s": 20, "cells": ("grid:1x1",)}, None),
    ],
)
def test_what_is_wrong_shows_before_anything_runs(options, message):
    settings = MemoriesStudySettings(**{"controllers": RULES, **options})
    if message is None:
        MemoriesStudy(settings).check()
        return
    with pytest.raises(InputError, match=message):
        MemoriesStudy(settings).check()


def test_a_folder_of_data_without_cities_is_refused(tmp_path):
    with pytest.raises(InputError, match="holds no city"):
        cells(MemoriesStudySettings(data=tmp_path))
    with pytest.raises(InputError, match="no such folder"):
        cells(MemoriesStudySettings(data=tmp_path / "nowhere"))


def test_what_was_tuned_for_a_controller_with_options_is_for_it_alone():
    chosen = {"approaching": True, "hysteresis": 1.0}
    settings = MemoriesStudySettings(tuned={"max-pressure,approaching=true": chosen})
    assert options_of(settings, parse_variant("max-pressure,approaching=true")) == chosen
    assert options_of(settings, Variant("max-pressure")) == {}


def test_options_tuned_for_others_only_are_refused():
    settings = MemoriesStudySettings(
        controllers=("random",), cells=("grid:1x1",), tuned={"sarsa": {"discount": 0.9}}
    )
    with pytest.raises(InputError, match="options of sarsa, none of which runs"):
        MemoriesStudy(settings).check()


def test_named_options_go_over_tuned_ones():
    settings = MemoriesStudySettings(tuned={"sarsa": {"epsilon": 0.3, "discount": 0.9}})
    assert options_of(settings, parse_variant("sarsa,epsilon=0.05")) == {
        "epsilon": 0.05,
        "discount": 0.9,
    }
    assert options_of(settings, Variant("dual-memory")) == {}


def test_learners_that_begin_with_the_test_are_named():
    settings = MemoriesStudySettings(untrained=("sarsa",))
    assert not is_trained(settings, parse_variant("sarsa,epsilon=0.05"))
    assert is_trained(settings, Variant("dual-memory"))
    assert not is_trained(settings, Variant("max-pressure"))
    with pytest.raises(UnknownNameError):
        contenders(MemoriesStudySettings(controllers=("sarssa",)))


def test_a_learner_overtakes_when_its_queue_stays_below():
    reference = [np.full(100, 5), np.full(100, 5)]
    first, then = np.full(100, 9), np.full(100, 4)
    # From second 100 on every window of 20 s is better; decisions are 10 s long.
    assert decisions_until_better([first, then], reference, 10, window_s=20) == 10
    assert decisions_until_better([then, then], reference, 10, window_s=20) == 0
    assert decisions_until_better([then, first], reference, 10, window_s=20) is None
    equal = [np.full(100, 5), np.full(100, 5)]
    assert decisions_until_better(equal, reference, 10, window_s=20) is None
    late = np.full(100, 4)
    late[50] = 100  # one bad window ends at second 151, in the second run
    assert decisions_until_better([then, late], reference, 10, window_s=20) == 16


def test_a_run_that_diverges_is_a_row_that_says_where(monkeypatch):
    settings = MemoriesStudySettings(
        controllers=("sarsa",), cells=("grid:1x1",), seeds=1, episodes=2, horizon_s=100
    )
    unit = units(settings)[0]

    def train(*_, observers, **__):
        raise DivergedError("sarsa", "values are", 70)

    monkeypatch.setattr(units_module, "train", train)
    result = run_unit(settings, unit)
    assert len(result.runs) == 1 and not result.series and not result.timings
    status = result.runs[0]["status"]
    assert status.startswith("DivergedError: ") and "at 70 s" in status
    assert status.endswith("(in episode 0 of the training)")
    assert "wait_per_spawned_s" not in result.runs[0]


def test_a_trained_learner_has_episodes_and_its_look_ups_of_the_test(monkeypatch):
    settings = MemoriesStudySettings(
        controllers=("sarsa",), cells=("grid:1x1",), seeds=1, episodes=2, horizon_s=300
    )
    made = units_module.make_controller

    def counting(*arguments, **options):
        controller = made(*arguments, **options)
        controller.calls = 0
        decide = controller.decide

        def counted(*given):
            controller.calls += 1
            return decide(*given)

        controller.decide = counted
        controller.lookups = lambda: {"table": controller.calls, "never": 0}
        return controller

    monkeypatch.setattr(units_module, "make_controller", counting)
    result = run_unit(settings, units(settings)[0])
    assert [row["episode"] for row in result.episodes] == [0, 1]
    run = result.runs[0]
    assert run["status"] == "ok" and run["training_s"] == 600 and run["intersections"] == 1
    counts = {row["source"]: row["lookups"] for row in result.lookups}
    assert counts == {"table": 30, "never": 0}  # 30 decisions in the test, 60 before it
    assert [row["time_s"] for row in result.series] == [0, 60, 120, 180, 240, 300]
    assert result.timings[0]["decisions"] == 30 and result.timings[0]["decide_s"] > 0
