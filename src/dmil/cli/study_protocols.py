"""``dmil study protocols``: methods under published protocols, recipe by recipe."""

from __future__ import annotations

from pathlib import Path

from dmil.cli.parameters import Option, options, part_of, split
from dmil.cli.studying import (
    RUNNING,
    RunningParameters,
    data_folder,
    folder_field,
    run_and_show,
    variants,
)
from dmil.studies.protocols import ProtocolsStudy, ProtocolsStudySettings


class ProtocolsParameters(ProtocolsStudySettings, RunningParameters):
    """The study of protocols, and how it is run here."""

    out: Path = folder_field("protocols")


PROTOCOLS_OPTIONS = (
    Option("protocols", "--protocols", "Study", "NAMES", read=split),
    Option("cities", "--cities", "Study", "NAMES", read=split, default="all"),
    Option("controllers", "--controllers", "Study", "NAMES", read=variants),
    *options("Study", "data DIR; seeds; first_seed; shift_s; horizon_s --steps; queue"),
    *RUNNING,
)


def protocols(settings: ProtocolsParameters, json: bool) -> None:
    """Run methods under published protocols, each an exact recipe, on recorded cities.

    A protocol fixes decision interval, clearance, phases, begin and measure. One of them,
    llmlight-30-5-4, is reproduced: the published max-pressure, run here, gives the published
    figures, so these stand beside ours. Of the others no published figure is shown. The report also
    shows what changes a figure: method, interval and phases, measure.

    For example:
        dmil study protocols --data data
        dmil study protocols --protocols llmlight-30-5-4 --cities JN1,HZ1 --seeds 1 --no-queue

    Without CityFlow's module all run in the queue simulator only, which the report says. Ctrl-C
    keeps finished runs; repeat the command to continue. The results are byte-identical for any
    number of processes.
    """
    chosen = part_of(settings, ProtocolsStudySettings)
    chosen = chosen.model_copy(update={"data": data_folder(chosen.data)})
    run_and_show(ProtocolsStudy(chosen), settings, json)
