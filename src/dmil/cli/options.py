"""Options that commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

OUTPUT = "Output"

Json = Annotated[
    bool,
    typer.Option(
        "--json",
        help="Print one JSON object, and nothing else, to standard output.",
        rich_help_panel=OUTPUT,
    ),
]
Debug = Annotated[
    bool,
    typer.Option(
        "--debug",
        help="Show the traceback of an error (as DMIL_DEBUG=1 does).",
        rich_help_panel=OUTPUT,
    ),
]
Trust = Annotated[
    list[str] | None,
    typer.Option(
        "--trust",
        metavar="MODULE:NAME",
        help="Your own code that a file (policy, tuned controller, --config) may name: it is "
        "imported and run. Code named by other options is trusted anyway.",
        rich_help_panel="Configuration",
    ),
]
Config = Annotated[
    Path | None,
    typer.Option(
        "--config",
        metavar="FILE.toml",
        help="Read parameters from a file; command-line options override it.",
        rich_help_panel="Configuration",
    ),
]
PrintConfig = Annotated[
    bool,
    typer.Option(
        "--print-config",
        help="Print all parameters as such a file, with comments, and exit.",
        rich_help_panel="Configuration",
    ),
]
