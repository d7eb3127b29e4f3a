import pickle

import pytest

from dmil import errors
from dmil.errors import DivergedError, DmilError, InputError, MissingExtraError, unknown_name


def test_a_message_says_place_finding_expectation_and_cure():
    error = InputError("length is -3 m", where="roads.json, road 4", expected="> 0", mend="fix it")
    assert str(error) == "roads.json, road 4: length is -3 m; expected > 0. Fix it."


def test_a_message_of_the_finding_alone():
    assert str(InputError("the file is empty")) == "the file is empty."


def test_a_closing_mark_is_not_doubled():
    assert str(InputError("empty", mend="did you mean 'a'?")) == "empty. Did you mean 'a'?"
    assert str(InputError("empty.")) == "empty."


def all_kinds(kind: type[DmilError]) -> set[type[DmilError]]:
    return {kind}.union(*(all_kinds(child) for child in kind.__subclasses__()))


def test_every_error_of_the_module_is_in_the_one_tree():
    defined = {item for item in vars(errors).values() if isinstance(item, type)}
    assert {kind for kind in defined if issubclass(kind, Exception)} <= all_kinds(DmilError)


@pytest.mark.parametrize(
    "kind",
    sorted((kind for kind in all_kinds(InputError) if kind.__module__ == errors.__name__), key=str),
)
def test_an_input_error_survives_the_way_between_processes(kind):
    error = kind("rate is -1", where="demand.json", expected="a rate >= 0", mend="remove the sign")
    back = pickle.loads(pickle.dumps(error))
    assert type(back) is kind
    assert str(back) == str(error)
    assert (back.problem, back.where, back.expected, back.mend) == (
        "rate is -1",
        "demand.json",
        "a rate >= 0",
        "remove the sign",
    )


def test_a_missing_extra_names_the_command_and_survives_pickling():
    error = MissingExtraError("ray")
    back = pickle.loads(pickle.dumps(error))
    assert "pip install 'dmil[ray]'" in str(error)
    assert (type(back), str(back), back.extra) == (MissingExtraError, str(error), "ray")


def test_an_unknown_name_suggests_the_nearest():
    error = unknown_name("controller", "Max-Presure", ["random", "max-pressure"], where="--with")
    assert str(error) == (
        "--with: there is no controller named 'Max-Presure'; "
        "expected one of max-pressure, random. Did you mean 'max-pressure'?"
    )


def test_an_unknown_name_near_nothing_suggests_nothing():
    error = unknown_name("controller", "zzz", ["random", "max-pressure"])
    assert error.mend is None
    assert "did you mean" not in str(error).lower()


def test_divergence_says_who_what_and_when_and_survives_the_way_between_processes():
    error = pickle.loads(pickle.dumps(DivergedError("dqn", "values of the phases", 120)))
    assert (error.controller, error.what, error.at_time_s) == (
        "dqn",
        "values of the phases",
        120,
    )
    assert "'dqn' diverged at 120 s: values of the phases that are not finite" in str(error)
