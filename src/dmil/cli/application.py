"""The command line with all commands, and its exit codes.

Exit codes: 0 success; 1 it ran, but something failed or it was stopped; 2 the user's error, with
one message and no traceback.
"""

from __future__ import annotations

import importlib
import io
import os
import re
import signal
import sys
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from dmil.cli.help import Command, CommandGroup
from dmil.cli.terminal import print_error, print_json, say
from dmil.errors import DmilError
from dmil.importing import only
from dmil.parallel.worker_server import start_worker_server
from dmil.version import __version__

COMMANDS = {
    "study": "Run a whole study, such as the paper's, and write its report.",
    "simulate": "Run one controller on one scenario and print what was measured.",
    "train": "Train a controller and save its policy to a file.",
    "evaluate": "Compare controllers and trained policies on the same vehicles.",
    "tune": "Tune options of controllers on separate seeds, with the same budget for each.",
    "calibrate": "Calibrate the queue simulator from one run of SUMO.",
    "export": "Export what a controller did, as signal programs for SUMO and as signal events.",
    "report": "Rewrite the report of a study: page, figures, tables.",
    "theory": "Bound the growth of the memory, and check its settings.",
    "scenarios": "List the scenarios, or describe one.",
    "doctor": "Check a network and its demand: what was read, and what is wrong.",
    "controllers": "List controllers, rewards and embeddings, or the settings of one.",
    "bench": "Measure the speed of simulator, controllers and look-ups.",
    "version": "Print the versions of dmil and its dependencies.",
}
WORK = {"study": "dmil.studies.paper.study", "tune": "dmil.experiments.tuning.scoring"}
"""Commands that run worker processes, and the module that these import."""
OK, FAILED, USER_ERROR = 0, 1, 2
SCENARIO = "--scenario"
IMPORT_PATH = re.compile(r"[^\W\d][\w.]*:[^\W\d]\w*")


class StoppedError(Exception):
    """A command was stopped by Ctrl-C or a signal; the message says how to go on."""


class LazyGroup(CommandGroup):
    """Commands that are imported when they run: help and version stay quick."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        for name, line in COMMANDS.items():
            self.add_command(TyperCommand(name=name, help=line), name)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Replace a command's name and one line by the command."""
        name, command, rest = super().resolve_command(ctx, args)
        if name in COMMANDS:
            if name in WORK and not {"--help", "-h", "--print-config"} & set(args):
                start_worker_server(WORK[name])  # it imports while this process still does
            made = getattr(importlib.import_module(f"dmil.cli.{name}"), name)
            if not isinstance(made, typer.Typer):
                function, made = made, typer.Typer(add_completion=False)
                made.command(cls=Command)(function)
            command = typer.main.get_command(made)
        return name, command, rest

    def invoke(self, ctx: Any) -> Any:
        """Run a command; what stops it is an error like any other."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            raise StoppedError("") from None

    def main(
        self,
        args: Sequence[str] | None = None,
        prog_name: str | None = None,
        complete_var: str | None = None,
        standalone_mode: bool = True,
        windows_expand_args: bool = True,
        **extra: Any,
    ) -> Any:
        """Run the command line and end with its exit code."""
        arguments = list(sys.argv[1:] if args is None else args)

        def run() -> Any:
            return TyperGroup.main(
                self,
                arguments,
                prog_name,
                complete_var,
                standalone_mode=False,
                windows_expand_args=windows_expand_args,
                **extra,
            )

        for stream in (sys.stdout, sys.stderr):
            # Not every terminal knows Greek: then a question mark is better than an error.
            if isinstance(stream, io.TextIOWrapper):
                stream.reconfigure(errors="replace")
        with _terminated_like_interrupted(), only(named_parts(arguments)):
            sys.exit(exit_code(run, arguments))


def named_parts(arguments: Sequence[str]) -> set[str]:
    """Return the import paths on a command line: naming them allows running them.

    The name of a scenario, such as ``cityflow:FOLDER``, is none.
    """
    scenarios = {k + 1 for k, argument in enumerate(arguments) if argument == SCENARIO}
    return {
        part
        for k, argument in enumerate(arguments)
        if k not in scenarios and not argument.startswith(f"{SCENARIO}=")
        for part in re.split(r"[\s,=\"'\[\]]", argument)
        if IMPORT_PATH.fullmatch(part)
    }


def exit_code(run: Callable[[], Any], arguments: Sequence[str]) -> int:
    """Run a command line; turn every end of it into messages and an exit code.

    What was typed is there because an error before the options are understood also honours
    ``--json`` and ``--debug``.
    """
    try:
        code = run()
        sys.stdout.flush()
        return code if isinstance(code, int) else OK
    except BrokenPipeError:
        # The reader has closed the pipe (`| head`). Python would complain again at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED
    except (DmilError, typer.TyperException) as error:
        _trace(arguments)
        message = str(error) if isinstance(error, DmilError) else error.format_message()
        _tell(message, arguments, hint=_hint(error))
        return USER_ERROR
    except (StoppedError, KeyboardInterrupt) as stop:
        _trace(arguments)
        _tell(str(stop), arguments, label="stopped")
        return FAILED
    except (MemoryError, OverflowError) as error:
        _trace(arguments)
        _tell(f"a number is too large for this machine ({error}); choose a smaller one", arguments)
        return USER_ERROR
    except Exception as error:
        # Not the user's to mend, unless a part of their own failed: where it arose is the message.
        traceback.print_exc()
        _tell(f"{type(error).__name__}: {error}", arguments)
        return FAILED


def _tell(message: str, arguments: Sequence[str], *, label: str = "error", hint: str = "") -> None:
    print_error(message, label=label)
    if hint:
        say(hint)
    if "--json" in arguments:
        print_json(
            {"error": message if label == "error" else ": ".join(filter(None, (label, message)))}
        )


def _hint(error: Exception) -> str:
    context = getattr(error, "ctx", None)
    return f"Help: {context.command_path} --help" if context is not None else ""


def _trace(arguments: Sequence[str]) -> None:
    if "--debug" in arguments or os.environ.get("DMIL_DEBUG", "0") not in ("", "0"):
        traceback.print_exc()


@contextmanager
def _terminated_like_interrupted() -> Iterator[None]:
    """Let SIGTERM do what Ctrl-C does: keep finished work and say so."""

    def interrupt(number: int, frame: object) -> None:
        raise KeyboardInterrupt

    try:
        before = signal.signal(signal.SIGTERM, interrupt)
    except ValueError:  # not in the main thread, where signals cannot arrive
        yield
        return
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


app = typer.Typer(
    cls=LazyGroup,
    invoke_without_command=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


@app.callback()
def _overview(
    ctx: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False,
) -> None:
    """Train, compare and inspect memory-based traffic-signal controllers.

    A controller chooses a phase for every intersection every few seconds. The headline metric is
    W/V_c: the mean wait per vehicle, in s, divided by the number of vehicles that reached their
    destination within the run. Lower is better.

    In five minutes:
        dmil simulate --scenario grid:3x3 --controller max-pressure
        dmil train --scenario grid:3x3 --out policy.npz
        dmil evaluate --policy policy.npz
        dmil study paper --preset literal --seeds 5 --out study

    Every command has --help, and prints one JSON object with --json. Exit codes: 0 success, 1
    something failed or was stopped, 2 invalid input.
    """
    if version:
        typer.echo(f"dmil {__version__}")
        raise typer.Exit
    if ctx.invoked_subcommand is None:
        ctx.get_help()
