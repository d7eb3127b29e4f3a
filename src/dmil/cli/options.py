"""Options that commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

OUTPUT, CONFIGURATION = "Output", "Configuration"


def option(panel: str, help: str, metavar: str | None = None, flag: str = "", **more: Any) -> Any:
    """Return an option of a group, called as its parameter where no flag is given."""
    flags = [flag] if flag else []
    return typer.Option(*flags, help=help, metavar=metavar, rich_help_panel=panel, **more)


Json = Annotated[
    bool,
    option(OUTPUT, "Print one JSON object, and nothing else, to standard output.", flag="--json"),
]
Debug = Annotated[
    bool,
    option(OUTPUT, "Show the traceback of an error (as DMIL_DEBUG=1 does).", flag="--debug"),
]
Trust = Annotated[
    list[str] | None,
    option(
        CONFIGURATION,
        "Your own code that a file (policy, tuned controller, --config) may name: it is "
        "imported and run. Code named by other options is trusted anyway.",
        "MODULE:NAME",
        "--trust",
    ),
]
Config = Annotated[
    Path | None,
    option(
        CONFIGURATION,
        "Read parameters from a file; command-line options override it.",
        "FILE.toml",
        "--config",
    ),
]
PrintConfig = Annotated[
    bool,
    option(
        CONFIGURATION,
        "Print all parameters as such a file, with comments, and exit.",
        flag="--print-config",
    ),
]
