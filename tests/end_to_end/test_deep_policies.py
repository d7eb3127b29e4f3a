"""Train, resume and evaluate a deep controller from the command line."""

TRAIN = ("train", "--scenario", "grid:1x2", "--reward", "queue", "--controller", "dqn-prioritised")
SMALL = ("--set", "buffer_capacity=70", "--set", "training_decisions=90", "--set", "hidden=16")


def test_a_resumed_training_equals_an_uninterrupted_one(dmil, tmp_path):
    whole, parts = tmp_path / "whole.npz", tmp_path / "parts.npz"
    dmil(*TRAIN, *SMALL, "--episodes", 3, "--out", whole)
    dmil(*TRAIN, *SMALL, "--episodes", 2, "--out", parts)
    dmil("train", "--resume", parts, "--episodes", 3, "--no-compare")
    assert parts.read_bytes() == whole.read_bytes()
    judged = dmil("evaluate", "--policy", parts, "--seeds", 2, "--jobs", 1).out
    assert "parts.npz" in judged
    assert "Learners: frozen" in judged
