"""What the ablation runs."""

import pytest

from dmil.controllers import CONTROLLERS
from dmil.errors import InputError, UnknownNameError
from dmil.studies.ablation import AblationStudy, AblationStudySettings
from dmil.studies.ablation.plan import PARTS, switched, units, variants
from dmil.studies.ablation.study import simulator_of


def of(*controllers, **settings):
    return AblationStudySettings(controllers=controllers, cells=("grid:1x1",), **settings)


def test_a_part_that_is_there_is_left_out_and_another_is_added():
    labels = {each.change: each.variant.label for each in switched(of("combined"))}
    assert labels["without turns that yield"] == "combined,yields=false"
    assert labels["without long waits"] == "combined,age=0.0"
    assert labels["without look-ahead"] == "combined,weight=0.0"
    assert not any(change.startswith("with ") for change in labels)
    labels = {each.change: each.variant.label for each in switched(of("factored"))}
    assert labels["with turns that yield"] == "factored,yields=true"
    assert labels["without learning"] == "factored,learning=false"
    assert "without look-ahead" not in labels


@pytest.mark.parametrize("name", ["combined", "factored", "lookahead"])
def test_every_switch_is_off_the_default_and_back_on_it(name):
    """The value a part has by default is one of its two: else a switch would change two things."""
    usual = CONTROLLERS[name].settings().model_dump()
    for part in PARTS.values():
        if part.option in usual:
            assert usual[part.option] in (part.off, part.on), part.option


def test_rules_with_a_guard_can_be_switched_too():
    chosen = of("max-pressure", parts=("guard", "approaching"))
    found = [each.variant.label for each in switched(chosen)]
    assert found == ["max-pressure,guard=false", "max-pressure,approaching=true"]
    assert [each.label for each in variants(chosen)] == ["max-pressure", *found]


def test_what_cannot_be_switched_is_refused():
    with pytest.raises(UnknownNameError, match="'wings'"):
        switched(of("factored", parts=("wings",)))
    with pytest.raises(InputError, match="none of its parts") as refused:
        switched(of("random"))
    assert "controller 'random'" in str(refused.value)
    with pytest.raises(UnknownNameError):
        AblationStudy(of("factord")).check()


def test_sumo_runs_on_its_own_roads_only():
    settings = AblationStudySettings(
        cells=("grid:3x3*4", "resco/cologne1", "sumo:a.sumocfg"), seeds=2, first_seed=600
    )
    where = [(unit.cell.name, unit.seed, simulator_of(unit.cell)) for unit in units(settings)]
    assert where == [
        ("grid:3x3*4", 600, "queue"),
        ("grid:3x3*4", 601, "queue"),
        ("resco/cologne1", 600, "sumo"),
        ("resco/cologne1", 601, "sumo"),
        ("sumo:a.sumocfg", 600, "sumo"),
        ("sumo:a.sumocfg", 601, "sumo"),
    ]
