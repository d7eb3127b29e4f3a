"""Growth bounds of dual memory against SARSA's table: plain numbers in and out."""

from dmil.theory.conditions import Condition, check_hyperparameters, failing
from dmil.theory.growth import (
    Ratios,
    StagingRule,
    best_case,
    enough_states,
    staged_rows,
    worst_case,
    worst_case_limit,
)
from dmil.theory.statements import STATEMENTS, Statement, Verdict, statements_markdown
from dmil.theory.trajectory import (
    MemorySizes,
    SizeBounds,
    counterexample,
    memory_sizes,
    size_bounds,
)

__all__ = [
    "STATEMENTS",
    "Condition",
    "MemorySizes",
    "Ratios",
    "SizeBounds",
    "StagingRule",
    "Statement",
    "Verdict",
    "best_case",
    "check_hyperparameters",
    "counterexample",
    "enough_states",
    "failing",
    "memory_sizes",
    "size_bounds",
    "staged_rows",
    "statements_markdown",
    "worst_case",
    "worst_case_limit",
]
