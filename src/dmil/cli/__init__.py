"""The command line, ``dmil``: one file per command, loaded when it is asked for.

A command is the function of its file's name, a group of commands the `typer.Typer` of that name.
"""

from __future__ import annotations

from dmil.cli.application import app


def main() -> None:
    """Run the command line and end the process with its exit code."""
    app(prog_name="dmil")


__all__ = ["app", "main"]
