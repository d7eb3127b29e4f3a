"""How a command explains itself: text that flows, examples as typed, options by group.

Typer's own tables give the help of an option a third of an 80-column line; these give it half.
"""

from __future__ import annotations

import inspect
import itertools
from collections.abc import Iterator
from typing import Any

from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text
from typer.core import TyperCommand, TyperGroup

from dmil.cli.terminal import results

LEFT_WIDTH = 26
GENERAL = "General"


class Command(TyperCommand):
    """A command with this help."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Print the help."""
        print_help(self, ctx)


class CommandGroup(TyperGroup):
    """A group of commands with this help."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Print the help."""
        print_help(self, ctx)


def print_help(command: Any, ctx: Any) -> None:
    """Print what a command does, its options by group, its commands."""
    console = results()
    pieces = " ".join(command.collect_usage_pieces(ctx))
    console.print(Text.assemble(("Usage: ", "bold"), f"{ctx.command_path} {pieces}"))
    console.print()
    console.print(Group(*_prose(command.help or "")))
    if isinstance(command, TyperGroup):
        rows = [
            (Text(name, "cyan"), Text((command.commands[name].help or "").split("\n\n")[0]))
            for name in command.list_commands(ctx)
        ]
        console.print(Text("Commands", "bold"), _grid(rows), sep="\n")
        console.print()
    for panel, options in _panels(command, ctx).items():
        rows = [(_name(option), _meaning(option)) for option in options]
        console.print(Text(panel, "bold"), _grid(rows), sep="\n")
        console.print()


def _prose(text: str) -> Iterator[RenderableType]:
    """Flow paragraphs; keep indented lines as they are."""
    for paragraph in inspect.cleandoc(text).split("\n\n"):
        for indented, lines in itertools.groupby(
            paragraph.splitlines(), key=lambda line: line.startswith("    ")
        ):
            if indented:
                block = Text("\n".join(line[4:] for line in lines), "cyan", overflow="fold")
                yield Padding(block, (0, 0, 0, 2))
            else:
                yield Text(" ".join(lines))
        yield Text()


def _panels(command: Any, ctx: Any) -> dict[str, list[Any]]:
    """Group options; arguments come first and what every command has comes last."""
    panels: dict[str, list[Any]] = {}
    for option in command.get_params(ctx):
        if getattr(option, "hidden", False):
            continue
        argument = option.param_type_name == "argument"
        name = "Arguments" if argument else getattr(option, "rich_help_panel", None) or GENERAL
        panels.setdefault(name, []).append(option)
    last = [name for name in ("Configuration", "Output", GENERAL) if name in panels]
    first = [name for name in panels if name not in last]
    return {name: panels[name] for name in [*first, *last]}


def _name(option: Any) -> Text:
    if option.param_type_name == "argument":
        return Text(option.metavar or option.name.upper(), "cyan")
    names = ", ".join(sorted(option.opts, key=len))
    if option.secondary_opts:
        names += f", {option.secondary_opts[0]}"
    metavar = "" if option.is_flag else f" {option.metavar or option.name.upper()}"
    return Text.assemble((names, "cyan"), metavar)


def _meaning(option: Any) -> Text:
    default = option.show_default if isinstance(option.show_default, str) else ""
    text = Text(option.help or "")
    if default:
        text.append(f" [default: {default}]", "dim")
    return text


def _grid(rows: list[tuple[Text, Text]]) -> RenderableType:
    grid = Table.grid(padding=(0, 2, 0, 0), expand=False)
    longest = max(len(name) for name, _ in rows)
    grid.add_column(width=min(longest, LEFT_WIDTH), overflow="fold")
    grid.add_column(overflow="fold")
    for name, meaning in rows:
        grid.add_row(name, meaning)
    return Padding(grid, (0, 0, 0, 2))
