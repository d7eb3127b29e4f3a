"""Means, paired differences and their intervals over seeds."""

from dmil.statistics.bootstrap import (
    Estimate,
    mean_interval,
    paired_difference,
    paired_ratio_of_ratios,
    standard_deviation,
)

__all__ = [
    "Estimate",
    "mean_interval",
    "paired_difference",
    "paired_ratio_of_ratios",
    "standard_deviation",
]
