"""``dmil study ablation``: its options and command."""

from __future__ import annotations

from pathlib import Path

from dmil.cli.parameters import options, part_of, settings_command
from dmil.cli.studying import (
    RUNNING,
    RunningParameters,
    data_folder,
    folder_field,
    run_and_show,
)
from dmil.studies.ablation import AblationStudy, AblationStudySettings


class AblationParameters(AblationStudySettings, RunningParameters):
    """The ablation, and how it is run here."""

    out: Path = folder_field("ablation")

    @property
    def study(self) -> AblationStudySettings:
        """What is run, without where and how."""
        values = dict(part_of(self, AblationStudySettings))
        values["data"] = data_folder(self.data)
        return AblationStudySettings(**values)


ABLATION_OPTIONS = (
    *options(
        "Study",
        "cells NAMES; controllers NAMES; parts NAMES; data DIR; seeds; first_seed; "
        "horizon_s --steps",
    ),
    *RUNNING,
)


@settings_command("study ablation", AblationParameters, ABLATION_OPTIONS)
def ablation(settings: AblationParameters, json: bool) -> None:
    """Run the ablation: what each part of our controllers is worth.

    combined, factored and lookahead run as they are, and with one part switched at a time: left out
    where they have it by default, added where they have not. The parts: yields (turns that yield
    count less), age (long waits), waves (only before a choice), outside (vehicles behind full
    entries), censored (learning from those who move), guard (for shared lanes), approaching,
    expected (announced vehicles), learning, look-ahead.

    The metric is delay, in s per vehicle. All variants meet the same vehicles in the same seed;
    shown are interquartile means of paired differences with 95 % intervals, and locked runs.

    For example:
        dmil study ablation
        dmil study ablation --cells resco/cologne1,resco/ingolstadt7 --seeds 10 --first-seed 600
        dmil study ablation --cells cityflow:jinan_3x4 --data data --parts learning --out jinan

    Networks of RESCO and files of SUMO run in SUMO and need the extra sumo. Ctrl-C keeps finished
    runs; repeat the command to continue. The results are byte-identical for any number of
    processes.
    """
    run_and_show(AblationStudy(settings.study), settings, json)
