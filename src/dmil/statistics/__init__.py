"""Means, paired differences, interquartile means and their intervals over seeds."""

from dmil.statistics.bootstrap import (
    Estimate,
    interval_levels,
    mean_interval,
    paired_difference,
    paired_ratio_of_ratios,
    standard_deviation,
)
from dmil.statistics.robust import interquartile_mean, stratified, wins

__all__ = [
    "Estimate",
    "interquartile_mean",
    "interval_levels",
    "mean_interval",
    "paired_difference",
    "paired_ratio_of_ratios",
    "standard_deviation",
    "stratified",
    "wins",
]
