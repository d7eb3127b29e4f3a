"""What is not the paper's, as its report lists it."""

from dmil.interpretations import INTERPRETATIONS
from dmil.reports.html import configuration_rows, find_value
from dmil.studies.paper.assumptions import assumptions, changed
from dmil.studies.paper.settings import PaperStudySettings


def test_assumptions_show_the_values_of_the_scenario():
    def told(configuration):
        return {each.meaning: each.value for each in assumptions(configuration)}

    usual = told({"grid": {"link_time_s": None}} | PaperStudySettings().model_dump(mode="json"))
    assert usual["time on a link between intersections"] == "5 s"
    assert not any("In this run" in value for value in usual.values())
    found = told({"grid": {"link_time_s": 3.0}, "demand": {"rate_veh_per_min": {"E": 2.5}}})
    assert found["time on a link between intersections"] == (
        "5 s. In this run: grid.link_time_s 3.0"
    )
    assert found["arrival rates λ_D"].endswith("In this run: demand.rate_veh_per_min.E 2.5")


def test_assumptions_show_the_values_that_differ():
    found = assumptions({"sarsa": {"learning_rate": 0.2}, "dual_memory": {"learning_rate": 0.1}})
    values = {item.meaning: item.value for item in found}
    assert values["learning rate"] == "0.1. In this run: sarsa.learning_rate 0.2"
    kinds = [item.kind for item in found]
    assert kinds == sorted(kinds, key=("fitted", "assumed", "corrected", "ours").index)
    presets = {"literal": {"epsilon_decay": 1.0}, "matched": {"epsilon_decay": 0.5}}
    values = {item.meaning: item.value for item in assumptions({"presets": presets})}
    assert values["ε during the test"].endswith("In this run: presets.matched.epsilon_decay 0.5")


def test_what_the_paper_states_is_not_listed_as_assumed():
    found = {item.meaning for item in assumptions({})}
    assert "normalisation of Table II" not in found and "κ" not in found
    # And the whole list of the table is there.
    assert found == {each.what for each in INTERPRETATIONS if each.mark != "P"}


def test_a_study_in_the_papers_own_setting_has_changed_nothing():
    assert changed(PaperStudySettings(seeds=3, grids=("2x2",)).model_dump(mode="json")) == {}
    settings = PaperStudySettings(horizon_s=600, ties="coin", sarsa={"learning_rate": 0.2})
    assert changed(settings.model_dump(mode="json")) == {
        "horizon_s": "600",
        "ties": "coin",
        "sarsa.learning_rate": "0.2",
    }


def test_the_whole_configuration_is_listed():
    rows = configuration_rows({"a": {"b": [1, 2], "c": None}, "seeds": list(range(30))})
    assert rows == [("a.b", "1, 2"), ("a.c", "–"), ("seeds", "0 … 29 (30 values)")]
    assert find_value({"a": {"b": 3}}, "b", 5) == 3 and find_value({}, "b", 5) == 5
