"""What goes where: results to standard output, messages and progress to standard error."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from rich.console import Console, RenderableType
    from rich.table import Table
    from rich.text import Text

    from dmil.scenarios import SignalTiming

Progress = Callable[[int, int], None]

PLAIN_STEPS = 10
"""Lines of progress where there is no terminal to draw a bar in."""


def results() -> Console:
    """Return standard output; rich leaves colours out where nobody would see them."""
    from rich.console import Console

    return Console(highlight=False)


def messages() -> Console:
    """Return standard error."""
    from rich.console import Console

    return Console(stderr=True, highlight=False)


def show(*parts: RenderableType) -> None:
    """Print a result for people."""
    console = results()
    for part in parts:
        console.print(part, markup=False)


def show_lines(lines: Sequence[Text]) -> None:
    """Print lines, cut at the edge of a terminal and whole elsewhere."""
    console = results()
    for line in lines:
        if console.is_terminal:
            console.print(line, no_wrap=True, overflow="ellipsis")
        else:
            console.print(line, soft_wrap=True)


def say(text: str) -> None:
    """Print a message that is no result, on lines as long as it needs."""
    messages().print(text, markup=False, soft_wrap=True)


def print_error(text: str, *, label: str = "error") -> None:
    """Print what went wrong, on lines as long as it needs."""
    from rich.text import Text

    parts = [(label, "bold red"), (f": {text}" if text else "", "")]
    messages().print(Text.assemble(*parts), soft_wrap=True)


def print_json(value: Mapping[str, Any]) -> None:
    """Print one JSON object; what is no number becomes null."""
    sys.stdout.write(json.dumps(_plain(value), allow_nan=False) + "\n")


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, Path):
        return str(value)
    if hasattr(value, "item"):  # a number of NumPy
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


@contextmanager
def progress(what: str, *, first_word: str = "") -> Iterator[Progress]:
    """Show how far something is: a bar with the time left, or a line every 10 % without a terminal.

    ``what`` is counted, such as "runs"; the first word says what goes on until one is finished.
    """
    if messages().is_terminal:
        with _bar(what, first_word) as advance:
            yield advance
    else:
        yield _lines(what)


@contextmanager
def _bar(what: str, first_word: str) -> Iterator[Progress]:
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        SpinnerColumn,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )
    from rich.progress import Progress as Bar

    bar = Bar(
        SpinnerColumn(),
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
        console=messages(),
        transient=True,
    )
    started: list[int] = []

    def advance(done: int, total: int) -> None:
        if not started:
            started.append(done)
            bar.add_task(first_word or what, total=total, completed=done)
        else:
            bar.update(bar.task_ids[0], completed=done, description=what)

    with bar:
        yield advance


def _lines(what: str) -> Progress:
    begun: dict[str, float] = {}

    def advance(done: int, total: int) -> None:
        if not begun:
            begun.update(time=monotonic(), done=done, told=done * PLAIN_STEPS // max(total, 1))
            if done:
                say(f"{done} of {total} {what} are there already")
            return
        step = done * PLAIN_STEPS // total
        if step > begun["told"]:
            begun["told"] = step
            spent_s = monotonic() - begun["time"]
            left_s = spent_s / (done - begun["done"]) * (total - done)
            say(f"{done} of {total} {what}, {100 * done // total} %, {_duration(left_s)} left")

    return advance


def _duration(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes}:{rest:02d} min" if minutes else f"{rest} s"


@contextmanager
def waiting(text: str) -> Iterator[None]:
    """Show that something takes a while."""
    console = messages()
    if console.is_terminal:
        with console.status(text):
            yield
    else:
        say(text)
        yield


def table(
    *heads: str,
    padding: tuple[int, ...] = (0, 1, 0, 0),
    overflow: Literal["ellipsis", "fold"] = "ellipsis",
) -> Table:
    """Return a table to be filled.

    ``>`` before a head stands for numbers at the right, ``!`` for words that are not broken.
    """
    from rich import box
    from rich.table import Table

    made = Table(box=box.SIMPLE_HEAD, show_edge=False, padding=padding)  # type: ignore[arg-type]
    for head in heads:
        justify: Literal["left", "right"] = "right" if head.startswith(">") else "left"
        whole = head.startswith((">", "!"))
        made.add_column(head.lstrip(">!"), justify=justify, no_wrap=whole, overflow=overflow)
    return made


def entries(lines: Mapping[str, Any]) -> RenderableType:
    """Return names and what they mean, in two columns."""
    from rich.table import Table
    from rich.text import Text

    grid = Table.grid(padding=(0, 2, 0, 0))
    grid.add_column(no_wrap=True)
    grid.add_column(overflow="fold")
    for name, meaning in lines.items():
        grid.add_row(Text(name, "cyan"), Text(str(meaning)))
    return grid


UNFINISHED = (
    "Vehicles that have not arrived count with their travel and waiting time up to the end of the "
    "run."
)


def own_or_s(seconds: int | None) -> str:
    """Write a time of `dmil.scenarios.SignalTiming`: seconds, or that each plan tells."""
    return "as each plan says" if seconds is None else f"{seconds} s"


def clearance(timing: SignalTiming) -> str:
    """Write how long clearance is, and whether all of it stops everybody."""
    kind = ", all-stop" if timing.clearance_kind == "all-stop" else ""
    return own_or_s(timing.clearance_s) + kind


def number(value: float, digits: int, sign: str = "") -> str:
    """Return a number with a true minus sign, or a dash where there is none.

    The sign "+" stands for a sign before positive numbers, too.
    """
    return "–" if value != value else f"{value:{sign}.{digits}f}".replace("-", "−")
