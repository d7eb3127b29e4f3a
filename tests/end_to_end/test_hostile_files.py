"""Files from strangers, and files that lie about: none of them runs code."""

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

import dmil
from dmil.cli import app
from dmil.errors import InputError
from dmil.experiments.tuning import Tuned, TuningSettings, load_tuned
from dmil.experiments.tuning.record import save_tuned
from dmil.importing import only
from dmil.training.policies import Policy, shapes_of
from tests.unit.cityflow.conftest import crossing_document

MINE = """
from pathlib import Path

from dmil.controllers.rules.baselines import MaxPressureController
from dmil.controllers.protocol import NO_MEMORY
from dmil.controllers.rules.baselines import MaxPressureSettings
from dmil.rewards import REWARDS
from dmil.symmetry import EMBEDDINGS

Path(__file__).with_name("ran").touch()
coarse = EMBEDDINGS["simple"]
reward = REWARDS["queue"]


class Learner(MaxPressureController):
    def __init__(self):
        super().__init__(MaxPressureSettings())

    def memory_use(self):
        return NO_MEMORY

    def arrays(self):
        return {}

    def restore(self, arrays):
        pass
"""
"""A module that leaves a trace when it is imported."""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "mine_of_a_stranger.py").write_text(MINE)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    yield tmp_path
    sys.modules.pop("mine_of_a_stranger", None)


@pytest.fixture
def policy(folder):
    """Return a function that writes a policy whose header says something else."""
    network = dmil.scenario("grid:1x1").network
    good = Policy("sarsa", {}, "diffusion", shapes_of(network), {}, {"scenario": "grid:1x1"})

    def write(**changes):
        dmil.save_policy(replace(good, **changes), folder / "bad.npz")
        return folder / "bad.npz"

    return write


@pytest.fixture
def command(capsys):
    """Return a function that runs a command and returns its exit code and what it said."""

    def run(*arguments):
        with pytest.raises(SystemExit) as end:
            app([str(each) for each in arguments], prog_name="dmil")
        return end.value.code, " ".join(capsys.readouterr().err.split())

    return run


def own(part):
    return f"mine_of_a_stranger:{part}"


HOSTILE = {
    "controller": {"controller": "os:system", "options": {"command": "touch ran"}},
    "controller of the folder": {"controller": own("Learner"), "options": {}},
    "reward": {"reward": own("reward")},
    "embedding": {"options": {"embedding": own("coarse")}},
}


@pytest.mark.parametrize("changes", HOSTILE.values(), ids=HOSTILE)
def test_a_policy_that_names_code_is_refused_and_nothing_runs(policy, folder, changes):
    with pytest.raises(InputError, match=r"bad\.npz: it names the .*none of dmil's"):
        dmil.load_policy(policy(**changes))
    assert not (folder / "ran").exists()


@pytest.mark.parametrize("name", ["simulate", "evaluate", "export", "train"])
def test_no_command_runs_what_a_policy_names(policy, folder, command, name):
    bad = policy(**HOSTILE["controller"])
    code, said = command(name, "--resume" if name == "train" else "--policy", bad)
    assert not (folder / "ran").exists()
    assert code == 2
    assert "names the controller 'os:system'" in said


RUN = ("--scenario", "grid:1x1", "--steps", 60)


@pytest.mark.parametrize(
    "named",
    [
        ("--controller", own("Learner")),
        ("--trust", own("Learner")),
        (f"--trust={own('Learner')}",),
    ],
)
def test_what_the_user_names_himself_may_run(policy, folder, command, named):
    mine = policy(controller=own("Learner"), options={})
    assert command("simulate", "--policy", mine, *RUN, *named, "--json")[0] == 0
    assert (folder / "ran").exists()


def test_workers_trust_what_the_user_named_and_nothing_else(policy, command):
    mine = policy(controller=own("Learner"), options={})
    evaluate = ("evaluate", "--policy", mine, *RUN, "--seeds", 2, "--jobs", 2, "--json")
    assert command(*evaluate)[0] == 2
    assert command(*evaluate, "--trust", own("Learner"))[0] == 0


@pytest.mark.parametrize(
    "text",
    [
        f'[controller]\nname = "{own("Learner")}"',
        f'controller = "{own("Learner")}"',
        f'reward = "{own("reward")}"\ncontroller = "sarsa"',
        f'[controller]\nname = "sarsa"\nembedding = "{own("coarse")}"',
        f'trust = ["{own("Learner")}"]',
    ],
)
def test_a_configuration_is_a_file_as_well(folder, command, text):
    (folder / "run.toml").write_text(text)
    assert command("simulate", *RUN, "--config", "run.toml")[0] == 2
    assert not (folder / "ran").exists()


def test_a_scenario_is_not_taken_for_a_name_of_code(folder, policy, command):
    (folder / "city").mkdir()
    (folder / "city" / "roadnet.json").write_text(json.dumps(crossing_document()[0]))
    (folder / "city" / "flow.json").write_text("[]")
    bad = policy(controller="cityflow:city", options={})
    code, said = command("simulate", "--scenario", "cityflow:city", "--policy", bad)
    assert code == 2
    assert "names the controller 'cityflow:city'" in said


@pytest.mark.parametrize(
    ("key", "value", "problem"),
    [
        ("controller", own("Learner"), "names the controller"),
        ("reward", own("reward"), "names the reward"),
        ("chosen", {"embedding": own("coarse")}, "names the embedding"),
    ],
)
def test_a_tuned_file_that_names_code_is_refused(folder, command, key, value, problem):
    settings = TuningSettings()
    tuned = Tuned(
        **{"dmil": dmil.__version__, "controller": "sarsa", "fixed": {}, "finished": True},
        **{"scenario": "grid:1x1", "recipe": {}, "same_demand": False, "simulator": "queue"},
        **{"reward": "diffusion", "horizon_s": 60, "settings": settings.model_dump(), "space": {}},
    )
    path = folder / "tuned.json"
    save_tuned(tuned.model_copy(update={key: value}), path)
    with pytest.raises(InputError, match=problem):
        load_tuned(path)
    for name in (("train", "--tuned", path, "--out", "p.npz"), ("evaluate", "--tuned", path)):
        assert command(*name, *RUN)[0] == 2
    assert not (folder / "ran").exists()


def test_a_program_says_what_it_trusts(policy):
    mine = policy(controller=own("Learner"), options={})
    with only(()):
        with pytest.raises(InputError):
            dmil.load_policy(mine)
        dmil.trust(own("Learner"))
        assert dmil.load_policy(mine).controller == own("Learner")
    with pytest.raises(InputError):  # and no longer than that
        dmil.load_policy(mine)


SHADOWS = (
    *("json", "numpy", "socket", "selectors", "pickle", "signal", "struct", "tempfile", "numba"),
    *("typing", "re", "__future__", "scipy", "pydantic", "typer", "rich", "random"),
    *("subprocess", "multiprocessing", "threading", "logging", "polars", "libsumo", "xml", "csv"),
)


@pytest.fixture
def shadows(folder):
    for name in SHADOWS:
        (folder / f"{name}.py").write_text(
            f"open({str(folder / 'ran')!r}, 'a').write({name!r} + ' ')\nraise SystemExit(7)\n"
        )
    return folder


def installed(folder):
    """Write a console script as installers do, outside of the folder."""
    script = folder.parent / f"{folder.name}-bin" / "dmil"
    script.parent.mkdir()
    script.write_text(
        "import sys\nfrom dmil.cli import main\nif __name__ == '__main__':\n    sys.exit(main())\n"
    )
    return script


def run(*arguments, folder, path):
    return subprocess.run(
        [sys.executable, *map(str, arguments)],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(path)},
        capture_output=True,
        text=True,
        timeout=300,
    )


OURS = Path(dmil.__file__).parents[1]
STARTS = {"module": lambda folder: ("-m", "dmil"), "script": lambda folder: (installed(folder),)}


@pytest.mark.parametrize("start", STARTS.values(), ids=STARTS)
def test_files_of_the_current_folder_are_not_run(shadows, start):
    # Workers, each with a process for SUMO, and others that draw the page.
    arguments = ("evaluate", *RUN, "--seeds", 2, "--jobs", 2, "--simulator", "sumo")
    arguments += ("--no-baselines", "--controller", "max-pressure", "--report", "page.html")
    done = run(*start(shadows), *arguments, folder=shadows, path=OURS)
    ran = shadows / "ran"
    assert not ran.exists(), ran.read_text()
    assert done.returncode == 0, done.stderr
