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
        help="Print one JSON object on standard output, and nothing else there.",
        rich_help_panel=OUTPUT,
    ),
]
Debug = Annotated[
    bool,
    typer.Option(
        "--debug",
        help="Show where in the program an error arose (as DMIL_DEBUG=1 does).",
        rich_help_panel=OUTPUT,
    ),
]
Trust = Annotated[
    list[str] | None,
    typer.Option(
        "--trust",
        metavar="MODULE:NAME",
        help="Code of yours that a file may name, too (a policy, a tuned controller, --config): it "
        "is imported and run. What another option names is trusted as well.",
        rich_help_panel="Configuration",
    ),
]
Config = Annotated[
    Path | None,
    typer.Option(
        "--config",
        metavar="FILE.toml",
        help="Read parameters from a file; options given here win over it.",
        rich_help_panel="Configuration",
    ),
]
PrintConfig = Annotated[
    bool,
    typer.Option(
        "--print-config",
        help="Print all parameters as such a file, with comments, and do nothing else.",
        rich_help_panel="Configuration",
    ),
]
