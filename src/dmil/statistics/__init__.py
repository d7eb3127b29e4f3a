"""What seeds show: means and their intervals, paired differences, profiles, rank tests."""

from dmil.statistics.bootstrap import (
    Estimate,
    Profile,
    interval_levels,
    mean_interval,
    paired_difference,
    paired_ratio_of_ratios,
    performance_profile,
    probability_of_improvement,
)
from dmil.statistics.growth import Stability, queue_growth, stability
from dmil.statistics.proportions import share_interval
from dmil.statistics.signed_rank import SignedRankTests, holm, signed_rank_tests
from dmil.statistics.summaries import interquartile_mean, standard_deviation, wins

__all__ = [
    "Estimate",
    "Profile",
    "SignedRankTests",
    "Stability",
    "holm",
    "interquartile_mean",
    "interval_levels",
    "mean_interval",
    "paired_difference",
    "paired_ratio_of_ratios",
    "performance_profile",
    "probability_of_improvement",
    "queue_growth",
    "share_interval",
    "signed_rank_tests",
    "stability",
    "standard_deviation",
    "wins",
]
