"""Tuning of controllers: the same budget for each, on seeds that no test has."""

from dmil.experiments.tuning.record import Tuned, TuningSettings, load_tuned, load_tuned_folder
from dmil.experiments.tuning.run import check_tuning, planned_tuning, tune
from dmil.experiments.tuning.spaces import search_space

__all__ = [
    "Tuned",
    "TuningSettings",
    "check_tuning",
    "load_tuned",
    "load_tuned_folder",
    "planned_tuning",
    "search_space",
    "tune",
]
