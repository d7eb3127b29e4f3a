"""``dmil bench``: figures of speed."""

from __future__ import annotations

import importlib.util
from dataclasses import asdict

import typer
from rich import box
from rich.table import Table

from dmil.benchmarks.figures import Figure
from dmil.cli.help import Command
from dmil.cli.options import Debug, Json
from dmil.cli.terminal import print_json, show, waiting

app = typer.Typer(add_completion=False)

SUMO_PACKAGES = ("libsumo", "sumo", "sumo_rl")
"""What the figures beside SUMO need."""


@app.command(cls=Command)
def bench(json: Json = False, debug: Debug = False) -> None:
    """Measure the speed of simulator, controllers and look-ups on this machine.

    It takes about a minute, and another one where SUMO is installed. All figures are medians
    over several rounds, measured in turns. A step is one simulated second of the whole network, the
    5×5 grid if no other is named; a decision is one intersection's, learning included. A ratio
    compares with another figure of the same rounds: its median, and between which extremes it lay.
    """
    with waiting("measuring"):
        from dmil.benchmarks.cities import city_figures
        from dmil.benchmarks.lookups import lookup_figures
        from dmil.benchmarks.neighbours import neighbour_figures
        from dmil.benchmarks.throughput import throughput_figures

        figures = [*throughput_figures(), *lookup_figures(), *neighbour_figures(), *city_figures()]
        if all(importlib.util.find_spec(name) for name in SUMO_PACKAGES):
            from dmil.benchmarks.sumo import sumo_figures

            figures += sumo_figures()
    if json:
        print_json({"figures": [asdict(figure) for figure in figures]})
        return
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, padding=(0, 1, 0, 0))
    table.add_column("what")
    table.add_column("figure", justify="right", no_wrap=True)
    table.add_column("unit", no_wrap=True)
    table.add_column("beside")
    for figure in figures:
        table.add_row(figure.name, _number(figure.value), figure.unit, _ratio(figure))
    show(table)


def _number(value: float) -> str:
    return f"{value:,.0f}".replace(",", " ") if value >= 1000 else f"{value:.3g}"


def _ratio(figure: Figure) -> str:
    if figure.ratio_median is None:
        return ""
    ends = f"{figure.ratio_min:.3g} to {figure.ratio_max:.3g}"
    return f"{figure.ratio_median:.3g} × {figure.against} ({ends})"
