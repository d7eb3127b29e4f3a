"""Training and testing: the loop, the phases around it, policies in files."""

from dmil.training.loop import Run, run
from dmil.training.phases import evaluate, train, train_prior, vehicles_of_seed
from dmil.training.policies import Policy, controller_of, load_policy, policy_of, save_policy

__all__ = [
    "Policy",
    "Run",
    "controller_of",
    "evaluate",
    "load_policy",
    "policy_of",
    "run",
    "save_policy",
    "train",
    "train_prior",
    "vehicles_of_seed",
]
