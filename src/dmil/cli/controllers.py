"""``dmil controllers``: which there are, and the settings of one."""

from __future__ import annotations

import inspect
from typing import Annotated, Any

import typer
from pydantic import BaseModel
from rich.text import Text

from dmil.cli.configuration import pair
from dmil.cli.options import Debug, Json
from dmil.cli.terminal import entries, print_json, show
from dmil.controllers import CONTROLLERS
from dmil.errors import unknown_name
from dmil.rewards import REWARDS
from dmil.symmetry import EMBEDDINGS, Embedding

MARKS = "[P] stated by the paper, [A] assumed, [F] fitted to its table."


def controllers(
    name: Annotated[
        str | None,
        typer.Argument(metavar="[NAME]", help="Controller to show.", show_default=False),
    ] = None,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """List controllers, rewards and embeddings, or the settings of one controller.

    For example:
        dmil controllers
        dmil controllers dual-memory

    A controller of your own is named by its import path, such as mine:MyController for a class in
    mine.py in the current folder; a reward likewise. Settings are changed by --set, such as
    --set embedding=complex, or in the table [controller] of a configuration file.
    """
    if name is None:
        _list(json)
        return
    if name not in CONTROLLERS:
        raise unknown_name("controller", name, CONTROLLERS)
    entry = CONTROLLERS[name]
    settings = _settings(entry.settings) if entry.settings else []
    if json:
        print_json(
            {"name": name, "summary": entry.summary, "learns": entry.learns, "settings": settings}
        )
        return
    show(Text(f"{name}: {entry.summary}", "bold"), "")
    if not settings:
        show("It has no settings.")
        return
    show(entries({pair(s["name"], s["default"]): s["description"] for s in settings}), "", MARKS)


def _list(json: bool) -> None:
    embeddings = {name: _embedding(each) for name, each in EMBEDDINGS.items()}
    rewards = {name: _first_line(function) for name, function in REWARDS.items()}
    if json:
        print_json(
            {
                "controllers": {
                    name: {"summary": entry.summary, "learns": entry.learns}
                    for name, entry in CONTROLLERS.items()
                },
                "rewards": rewards,
                "embeddings": embeddings,
            }
        )
        return
    learns = {False: "", True: " (learns)"}
    summaries = {name: entry.summary + learns[entry.learns] for name, entry in CONTROLLERS.items()}
    for title, lines in (
        ("Controllers", summaries),
        ("Rewards for learners", rewards),
        ("Embeddings: which states share what was learned", embeddings),
    ):
        show(Text(title, "bold"), entries(lines), "")
    show("Settings of one: dmil controllers dual-memory")


def _settings(kind: type[BaseModel]) -> list[dict[str, Any]]:
    return [
        {"name": name, "default": field.default, "description": field.description}
        for name, field in kind.model_fields.items()
    ]


def _first_line(function: Any) -> str:
    line = (inspect.getdoc(function) or "").split("\n")[0]
    return line.removeprefix("Return ").removeprefix("the ")


def _embedding(each: Embedding) -> str:
    parts = []
    if each.scale_levels:
        parts.append(f"scaled to {each.scale_levels} levels")
    if each.cell_width > 1:
        parts.append(f"cells of {each.cell_width} vehicles")
    if each.rotations:
        parts.append("rotated states are equivalent")
    if each.tolerance:
        parts.append(f"queues may differ by {each.tolerance}")
    return "; ".join(parts) or "the queues themselves"
