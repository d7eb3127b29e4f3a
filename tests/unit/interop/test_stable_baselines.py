"""examples/stable_baselines.py trains PPO and judges it."""

import importlib.util
from pathlib import Path

import pytest

PATH = Path(__file__).resolve().parents[3] / "examples" / "stable_baselines.py"


@pytest.mark.skipif(
    importlib.util.find_spec("stable_baselines3") is None,
    reason="stable-baselines3 is no extra of this package: it brings torch",
)
@pytest.mark.slow
# Its own, and torch's.
@pytest.mark.filterwarnings("default")
def test_the_example_learns_something(tmp_path, capsys):
    spec = importlib.util.spec_from_file_location("stable_baselines", PATH)
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    model = tmp_path / "ppo.zip"
    example.main(["--steps", "8000", "--seeds", "5", "--model", str(model)])
    lines = capsys.readouterr().out.splitlines()
    means = {line.split()[0]: float(line.split()[1]) for line in lines[1:]}
    assert means["PPO"] < 0.8 * means["random"]
    assert example.TrainedPolicy(str(model))
