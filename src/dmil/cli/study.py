"""``dmil study``: many runs, one report."""

from __future__ import annotations

from pathlib import Path

import typer
from pydantic import Field

from dmil.cli.choices import DEMAND_OPTIONS
from dmil.cli.help import Command, CommandGroup
from dmil.cli.parameters import Option, set_option, settings_command, split
from dmil.cli.study_memories import memories
from dmil.cli.study_running import RUNNING, RunningParameters, run_and_show
from dmil.errors import unknown_name
from dmil.studies import (
    PRESETS,
    PaperStudy,
    PaperStudySettings,
    RescoStudy,
    RescoStudySettings,
)


class StudyParameters(PaperStudySettings, RunningParameters):
    """The paper's study, and how it is run here."""

    out: Path = Field(
        Path("study"),
        description="Folder for results and report; a study started there is resumed.",
    )

    @property
    def study(self) -> PaperStudySettings:
        """What is run, without where and how."""
        names = PaperStudySettings.model_fields
        return PaperStudySettings(**{name: getattr(self, name) for name in names})


class RescoParameters(RescoStudySettings, RunningParameters):
    """The study on the RESCO benchmark, and how it is run here."""

    out: Path = Field(
        Path("resco"),
        description="Folder for results and report; a study started there is resumed.",
    )

    @property
    def study(self) -> RescoStudySettings:
        """What is run, without where and how."""
        names = RescoStudySettings.model_fields
        return RescoStudySettings(**{name: getattr(self, name) for name in names})


def _presets(text: str) -> list[str]:
    if text == "all":
        return list(PRESETS)
    for name in split(text):
        if name not in PRESETS:
            raise unknown_name("preset", name, [*PRESETS, "all"], where="--preset")
    return split(text)


OPTIONS = (
    Option("presets", "--preset", "Study", "NAMES", read=_presets, default="all"),
    Option("grids", "--grids", "Study", "NAMES"),
    Option("seeds", "--seeds", "Study"),
    Option("first_seed", "--first-seed", "Study"),
    Option("horizon_s", "--steps", "Study"),
    Option("load", "--load", "Study"),
    Option("rewards", "--rewards", "Study", "NAMES"),
    Option("equal_epsilon", "--equal-epsilon", "Study"),
    Option("complex_readings", "--complex-readings", "Study", "NAMES"),
    Option("variant_seeds", "--variant-seeds", "Study"),
    *DEMAND_OPTIONS,
    set_option(
        "Study",
        help="Value of the study, such as training_epsilon=0.2.",
        example="sarsa.learning_rate=0.2",
    ),
    *RUNNING,
)

RESCO_OPTIONS = (
    Option("scenarios", "--scenarios", "Study", "NAMES", read=split),
    Option("seeds", "--seeds", "Study"),
    Option("first_seed", "--first-seed", "Study"),
    Option("episodes", "--episodes", "Study"),
    Option("horizon_s", "--steps", "Study"),
    Option("resample", "--resample", "Study"),
    Option("train_in", "--train-in", "Study"),
    Option("judge", "--judge", "Study"),
    Option("calibrate", "--calibrate", "Study"),
    Option("emissions", "--emissions", "Study"),
    Option("reward", "--reward", "Study"),
    set_option(
        "Study", help="Value of the study, such as episodes=20.", example="sarsa.learning_rate=0.2"
    ),
    *RUNNING,
)

app = typer.Typer(cls=CommandGroup, add_completion=False, invoke_without_command=True)


@app.callback()
def _studies(ctx: typer.Context) -> None:
    """Run a whole study and write its report.

    A study runs many controllers on many seeds, stores every run in a folder (Parquet tables, see
    docs/results.md) and turns them into one page of figures, tables and verdicts.

        dmil study paper --help
    """
    if ctx.invoked_subcommand is None:
        ctx.get_help()


app.command(cls=Command)(memories)


@app.command(cls=Command)
@settings_command("study paper", StudyParameters, OPTIONS)
def paper(settings: StudyParameters, json: bool) -> None:
    """Run the paper's study: 24 architectures of memory and reward, and the baselines.

    Each preset is one reading of what the paper leaves open: literal (as written), decaying (ε
    falls during a run), matched (closest to the paper's magnitudes). In each, all architectures and
    baselines meet the same vehicles in the same seed.

    The metric is W/V_c: the mean wait per vehicle, in s, divided by the vehicles that reached their
    destination by the end of the run. Lower is better. The report compares it with the paper's
    Table II, longest-queue-first and max-pressure, and gives a verdict on each of the paper's
    claims, computed from these runs.

    For example:
        dmil study paper
        dmil study paper --preset literal --grids 1x1,3x3 --seeds 5 --out trial
        dmil study paper --steps 3600 --out long
        dmil study paper --executor ray --ray-address auto --seeds 1000 --out large

    Ctrl-C keeps finished runs; repeat the command to continue. The results are byte-identical for
    any number of processes and interruptions. Settings without an option, such as the size of
    short-term memory, go into a file: --print-config shows all. Marks: [P] stated by the paper, [A]
    assumed because no other reading tried gives its magnitudes, [F] fitted to its table.
    """
    run_and_show(PaperStudy(settings.study), settings, json)


@app.command(cls=Command)
@settings_command("study resco", RescoParameters, RESCO_OPTIONS)
def resco(settings: RescoParameters, json: bool) -> None:
    """Run the study on the RESCO benchmark: real roads, evaluated in SUMO.

    Eight networks with one hour of recorded or synthetic demand, decisions every 10 s, yellow 3 s.
    SARSA and dual memory train in the queue simulator, calibrated by one SUMO run per network, are
    then frozen and evaluated in SUMO on other seeds, against the network's own program, SUMO's
    actuated control, longest-queue-first, max-pressure and random. All are also evaluated in the
    queue simulator: how well the simulators agree is part of the result.

    The metric is the average delay, in s per vehicle: time lost against free flow, plus the wait
    before entering the network. Lower is better. Published numbers are shown for comparison.

    For example:
        dmil study resco
        dmil study resco --scenarios cologne1,ingolstadt1 --seeds 2 --episodes 10 --out small
        dmil study resco --train-in sumo --scenarios cologne8 --out trained-in-sumo

    It needs the extra sumo: pip install 'dmil[sumo]'. Ctrl-C keeps finished runs; repeat the
    command to continue. The results are byte-identical for any number of processes.
    """
    run_and_show(RescoStudy(settings.study), settings, json)
