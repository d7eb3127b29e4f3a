"""``dmil bench``: figures of speed."""

from __future__ import annotations

import importlib.util
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from dmil.cli.options import Debug, Json, option
from dmil.cli.terminal import print_json, progress, show, table, waiting

if TYPE_CHECKING:
    from dmil.benchmarks.figures import SpeedFigure

SUMO_PACKAGES = ("libsumo", "sumo", "sumo_rl")
"""What the figures beside SUMO need."""


def bench(
    against: Annotated[
        Path | None,
        option(
            "Bench",
            "Checkout of another version: both are measured alternately and compared.",
            "DIR",
        ),
    ] = None,
    rounds: Annotated[
        int, option("Bench", "Number of times that both versions are measured.", min=1)
    ] = 3,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Measure the speed of simulator, controllers and look-ups on this machine.

    It takes about a minute, and another one where SUMO is installed. All figures are medians over
    several interleaved rounds. A step is one simulated second of the whole network, by default the
    5×5 grid; a decision is that of one intersection, learning included. A ratio compares with
    another figure of the same rounds: median and range.

    For example:
        dmil bench
        dmil bench --against ../before
    """
    if against is not None:
        _compare(against, rounds, json)
        return
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
    found = table("what", ">figure", "!unit", "beside")
    for figure in figures:
        found.add_row(figure.name, _number(figure.value), figure.unit, _ratio(figure))
    show(found)


def _compare(folder: Path, rounds: int, json: bool) -> None:
    from dmil.benchmarks.against import figures_against

    with progress("measurements", first_word="measuring") as advance:
        compared = figures_against(folder, rounds=rounds, progress=advance)
    if json:
        print_json({"figures": [asdict(each) for each in compared]})
        return
    found = table("what", ">here", ">there", "!unit", "here / there")
    for each in compared:
        ratio = f"{each.ratio:.3g} ({each.ratio_min:.3g} to {each.ratio_max:.3g})"
        found.add_row(each.name, _number(each.here), _number(each.there), each.unit, ratio)
    show(found)


def _number(value: float) -> str:
    return f"{value:,.0f}".replace(",", " ") if value >= 1000 else f"{value:.3g}"


def _ratio(figure: SpeedFigure) -> str:
    if figure.ratio_median is None:
        return ""
    ends = f"{figure.ratio_min:.3g} to {figure.ratio_max:.3g}"
    return f"{figure.ratio_median:.3g} × {figure.against} ({ends})"
