"""Small seeded runs of the factored memory with exact numbers: what a change would change unseen.

After a change that is meant to change them: python tests/golden/test_golden_factored.py
"""

import json
from pathlib import Path

import pytest

from dmil.controllers import make_controller
from dmil.rewards import REWARDS
from dmil.scenarios import SignalTiming, scenario
from dmil.simulation import QueueSimulator
from dmil.training import evaluate, vehicles_of_seed

FILE = Path(__file__).with_name("factored.json")
RUNS = {
    "grid:1x1": ("grid:1x1", SignalTiming(), {}),
    "grid:3x3": ("grid:3x3", SignalTiming(), {}),
    "grid:3x3, clearance": ("grid:3x3", SignalTiming(clearance_s=3, startup_lost_s=1), {}),
    "grid:3x3, no announcements": ("grid:3x3", SignalTiming(), {"expected": 0.0, "wave": 0.0}),
}
SEED = 1


def numbers(name, timing, options):
    """Run for 900 s, learning; counts are exact, the table's sums to five digits.

    The table holds 32-bit numbers, in whose sums machines may differ in the last bit.
    """
    made = scenario(name, horizon_s=900, timing=timing)
    controller = make_controller("factored", options)
    vehicles = vehicles_of_seed(made, SEED)
    run = evaluate(QueueSimulator(made), controller, vehicles, REWARDS["diffusion"], SEED)
    arrays = controller.arrays()
    return {
        "spawned_veh": run.measures.spawned_veh,
        "arrived_veh": run.measures.arrived_veh,
        "wait_veh_s": run.measures.wait_veh_s,
        "entries": run.memory[-1].entries_total,
        "bytes": run.memory[-1].bytes_total,
        "times": int(arrays["times"].sum()),
        "residual": float(f"{float(arrays['residual'].sum(dtype=float)):.5g}"),
        "lookups": controller.lookups(),
    }


@pytest.mark.parametrize("name", RUNS)
def test_the_run_gives_the_numbers_on_file(name):
    found, expected = numbers(*RUNS[name]), json.loads(FILE.read_text())[name]
    assert found.pop("residual") == pytest.approx(expected.pop("residual"), rel=1e-4)
    assert found == expected


def test_there_is_a_number_for_every_run():
    on_file = json.loads(FILE.read_text())
    assert set(on_file) == set(RUNS)
    # They differ, or they would not tell the options apart.
    assert len({run["residual"] for run in on_file.values()}) == len(RUNS)


if __name__ == "__main__":
    found = {name: numbers(*run) for name, run in RUNS.items()}
    lines = [f"  {json.dumps(name)}: {json.dumps(run)}" for name, run in found.items()]
    FILE.write_text("{\n" + ",\n".join(lines) + "\n}\n")
