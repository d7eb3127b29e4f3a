"""Train, resume and evaluate look-ahead from the command line."""

TRAIN = ("train", "--scenario", "grid:1x2", "--controller", "lookahead", "--clearance", 3)
TRAIN += ("--no-compare",)


def test_a_resumed_training_equals_an_uninterrupted_one_and_is_evaluated(dmil, tmp_path):
    whole, parts = tmp_path / "whole.npz", tmp_path / "parts.npz"
    dmil(*TRAIN, "--episodes", 3, "--out", whole)
    dmil(*TRAIN, "--episodes", 1, "--out", parts)
    dmil("train", "--resume", parts, "--episodes", 3, "--no-compare")
    assert parts.read_bytes() == whole.read_bytes()
    judged = dmil(
        *("evaluate", "--policy", whole, "--clearance", 3, "--seeds", 1, "--jobs", 1, "--json")
    )
    assert judged.json["controllers"][0]["controller"] == "whole.npz"


def test_an_option_out_of_range_is_one_clear_error(dmil):
    done = dmil(
        *("evaluate", "--scenario", "grid:1x1", "--controller", "lookahead,depth=3"),
        *("--seeds", 1),
        code=2,
    )
    assert "Traceback" not in done.err
    assert "depth = 3" in done.err
