"""Parts that a user brings, by import path."""

import sys

import pytest

from dmil.errors import InputError
from dmil.importing import import_object
from dmil.rewards import make_reward
from dmil.symmetry import Embedding, embedding

TEXT = """
from dmil.symmetry import Embedding
COARSE = Embedding("coarse", cell_width=4)
def reward(before, after, network): ...
"""


@pytest.fixture
def module(tmp_path, monkeypatch):
    """A module in the current folder, which is not on the path: as for an installed command."""
    (tmp_path / "brought_by_a_user.py").write_text(TEXT)
    monkeypatch.setattr(sys, "path", [place for place in sys.path if place])
    monkeypatch.chdir(tmp_path)
    yield "brought_by_a_user"
    sys.modules.pop("brought_by_a_user", None)


def test_a_module_in_the_current_folder_is_found(module):
    assert import_object(f"{module}:reward", "reward").__name__ == "reward"


def test_an_embedding_and_a_reward_of_ones_own(module):
    assert embedding(f"{module}:COARSE") == Embedding("coarse", cell_width=4)
    assert make_reward(f"{module}:reward") is sys.modules[module].reward


@pytest.mark.parametrize(
    ("make", "path", "says"),
    [
        (embedding, ":reward", "it is a function; expected a dmil.Embedding"),
        (make_reward, ":COARSE", "it is a Embedding; expected a function"),
        (make_reward, ":rewards", "has no 'rewards'"),
        (embedding, "_else:COARSE", "cannot be imported"),
    ],
)
def test_what_cannot_be_used_is_named(module, make, path, says):
    with pytest.raises(InputError, match=says) as caught:
        make(f"{module}{path}")
    assert f"'{module}{path}'" in str(caught.value)
