"""The report of the study on the RESCO benchmark: its tables, the main page, one per network."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import polars as pl

from dmil.analysis.panel import rows_by
from dmil.doctor import examine, read_case
from dmil.errors import DmilError
from dmil.reports.export import Figure, csv, figure, latex, script_bundle, slug
from dmil.reports.html import check_preset, configuration_rows, environment, shared_values
from dmil.reports.labels import contender_label, counted, network_label, simulator_label
from dmil.reports.network_chart import network_chart
from dmil.results import Results
from dmil.results.metrics import METRICS, NETWORK_PAGE
from dmil.studies.resco.contenders import JUDGES
from dmil.studies.resco.figures import GOAL, figures_of_network, figures_of_study
from dmil.studies.resco.published import (
    METHODS,
    METRIC,
    SOURCE,
    Published,
    published_by,
    published_learners,
)
from dmil.studies.resco.settings import UNBLOCKED
from dmil.studies.resco.tables import RescoTables, published_table, resco_tables

PRESET = "resco"
PAGES = "scenarios"
"""Folder of the networks' pages."""
LIBRARY = f"{PAGES}/charts.js"
"""Script that draws figures; the networks' pages share it."""
FEW_SEEDS = 8


class RescoReport:
    """What the report of this study is made of: a `dmil.studies.registry.Report`."""

    def __init__(
        self, results: Results, tables: RescoTables | None = None, preset: str | None = None
    ) -> None:
        check_preset(preset, PRESET)
        self._results = results
        self._tables = tables or resco_tables(results)
        self._scenarios = self._tables.judged.scenarios
        self._facts: dict[str, dict[str, str]] = {}

    def tables(self) -> dict[str, str | bytes]:
        """Return the tables' files by name."""
        made = self._tables
        parts = ("overall", "locks", "training", "agreement")
        own = {name: getattr(made, name) for name in parts}
        own |= {"delay": made.headline, "metrics": made.scores, "published": published_table()}
        return {
            **{f"tables/{name}.csv": csv(table) for name, table in own.items()},
            "tables/delay.tex": delay_latex(made.headline, made.judged.judge),
            "tables/agreement.tex": agreement_latex(made.agreement),
        }

    def figures(self) -> Iterator[Figure]:
        """Yield the figures as they are made."""
        yield from figures_of_study(self._tables)
        for scenario in self._scenarios:
            yield from self._network(scenario)
            yield from figures_of_network(self._results, self._tables, scenario)

    def pages(self, figures: list[Figure]) -> dict[str, str]:
        """Return the pages by name."""
        templates = environment(__package__)
        templates.filters |= {
            "contender": contender_label,
            "network": network_label,
            "simulator": simulator_label,
            "page": page_of,
            "percent": lambda value: None if value is None else 100 * value,
        }
        own = [figure for figure in figures if not figure.scenario]
        main = templates.get_template("page.html.j2")
        pages = {"report.html": main.render(self._shared(own), **self._main())}
        of_network = templates.get_template("network.html.j2")
        for scenario in self._scenarios:
            own = [figure for figure in figures if figure.scenario == scenario]
            values = self._shared(own) | self._of_network(scenario)
            pages[page_of(scenario)] = of_network.render(values)
        return pages | {LIBRARY: script_bundle()}

    def _network(self, scenario: str) -> Iterator[Figure]:
        """Yield the network's picture, and keep its facts, where its files are installed."""
        try:
            diagnosis = examine(read_case((scenario,)))
        except DmilError:
            return
        facts, traffic = diagnosis.network, diagnosis.traffic
        self._facts[scenario] = {
            "signals": f"{facts.intersections}, of {counted(facts.shapes, 'shape')}",
            "other junctions": f"{facts.junctions}",
            "roads": f"{facts.links} links, {facts.road_km:.1f} km, "
            f"{facts.slowest_km_per_h:.0f} to {facts.fastest_km_per_h:.0f} km/h",
        }
        if traffic is not None:
            degrees = sorted((load.degree for load in traffic.load), reverse=True)
            self._facts[scenario] |= {
                "route": f"{traffic.length_m:.0f} m, {traffic.free_flow_s:.0f} s without delay, "
                f"{traffic.signals_passed:.1f} signals on average",
                "busiest signal": f"{100 * degrees[0]:.0f} % of its capacity in its busiest "
                "15 minutes, at the best division of green",
            }
        name = f"{slug(scenario.rpartition('/')[2])}_network"
        caption = "Roads by lanes and speed; signals of one colour and letter share a shape."
        yield figure(name, "network", scenario, caption, network_chart(diagnosis))

    def _shared(self, figures: list[Figure]) -> dict[str, Any]:
        runs = self._tables.judged
        return shared_values(self._results, figures) | {
            "judge": runs.judge,
            "in_sumo": runs.judge in JUDGES,
            "trained_in": " and ".join(map(simulator_label, runs.trained_in)),
            "simulators": runs.simulators,
            "seeds": runs.seeds,
            "few_seeds": FEW_SEEDS,
            "scenarios": runs.scenarios,
            "contenders": runs.names,
            "published": {name: published_by(name) for name in runs.scenarios},
            "source": SOURCE,
        }

    def _main(self) -> dict[str, Any]:
        made = self._tables
        configuration = self._results.manifest.get("configuration", {})
        judged = pl.col("simulator") == made.judged.judge
        size = made.scores.filter(judged & pl.col("reward").is_not_null())
        bytes_total, entries = (
            rows_by(size.filter(pl.col("metric") == name), "contender", "scenario")
            for name in ("bytes_total", "entries_per_agent")
        )
        return {
            "resample": configuration.get("resample", False),
            "delays": rows_by(made.headline, "contender", "scenario"),
            "locks": rows_by(made.locks, "contender", "scenario", "simulator"),
            "protocols": made.locks["simulator"].unique(maintain_order=True).to_list(),
            "unblocked": rows_by(
                made.scores.filter(
                    (pl.col("metric") == METRIC) & (pl.col("simulator") == UNBLOCKED)
                ),
                "contender",
                "scenario",
            ),
            "training": rows_by(made.training, "contender", "scenario"),
            "overall": made.overall.filter(judged).rows(named=True),
            "agreement": rows_by(made.agreement, "metric", "scenario", "simulator"),
            "goal": GOAL,
            "bytes": bytes_total,
            "entries": entries,
            "published_learners": published_learners(made.judged.scenarios),
            "configuration": configuration_rows(configuration),
        }

    def _of_network(self, scenario: str) -> dict[str, Any]:
        made = self._tables
        here, training = (
            table.filter(pl.col("scenario") == scenario) for table in (made.scores, made.training)
        )
        vehicles = made.judged.of("spawned_veh", simulator=made.judged.judge, scenario=scenario)
        known = vehicles[vehicles == vehicles]
        spread = {f"{value:,.0f}" for value in (known.min(), known.max())} if known.size else set()
        facts = self._facts.get(scenario, {}) | {"vehicles": " to ".join(sorted(spread)) or "–"}
        present = set(here.filter(pl.col("simulator") == made.judged.judge)["metric"])
        return {
            "scenario": scenario,
            "facts": facts,
            "columns": {name: METRICS[name] for name in NETWORK_PAGE if name in present},
            "metrics": rows_by(here, "contender", "simulator", "metric"),
            "metric": METRIC,
            "locks": rows_by(
                made.locks.filter(pl.col("scenario") == scenario), "contender", "simulator"
            ),
            "training": rows_by(training, "contender", "trained_in"),
        }


def page_of(scenario: str) -> str:
    """Return the file of a network's page, seen from the main one (ours)."""
    return f"{PAGES}/{slug(scenario.rpartition('/')[2])}.html"


REPORT = RescoReport
"""What makes the report of such a study."""


def delay_latex(headline: pl.DataFrame, judge: str) -> str:
    r"""Return controllers by networks as a LaTeX tabular: the delay's median, interquartile mean.

    An asterisk marks those that are not shown to be worse than the best.
    """
    networks = headline["scenario"].unique(maintain_order=True).to_list()
    entries = rows_by(headline, "contender", "scenario")
    ours = [
        [contender_label(name), *(_entry(entries.get((name, network))) for network in networks)]
        for name in headline["contender"].unique(maintain_order=True)
    ]
    known = {name: published_by(name) for name in networks}
    theirs = [
        [f"published {name}", *(_published(values.get(name)) for values in known.values())]
        for name in METHODS
        if any(name in values for values in known.values())
    ]
    notes = (
        f"average delay in s in {simulator_label(judge)}: median over seeds, interquartile mean "
        "[95 % interval];",
        "* not shown to be worse than the best (paired interval);",
        f"published: best training episode (mean of the last 10), {SOURCE}",
    )
    return _latex(notes, ["", *map(network_label, networks)], ours, theirs)


def agreement_latex(agreement: pl.DataFrame) -> str:
    r"""Return Kendall's \tau of the delays by network as a LaTeX tabular."""
    chosen = agreement.filter(pl.col("metric") == "delay_s")
    simulators = chosen["simulator"].unique(maintain_order=True).to_list()
    entries = rows_by(chosen, "scenario", "simulator")
    rows = [
        [
            "all" if scenario is None else network_label(scenario),
            *(text for each in simulators for text in _agreement(entries.get((scenario, each)))),
        ]
        for scenario in chosen["scenario"].unique(maintain_order=True)
    ]
    notes = (
        "Kendall's tau of the ranks by delay, SUMO against the queue simulator;",
        "median of delay / SUMO's delay - 1 in %; [95 % interval over seeds]",
    )
    heads = [
        f"{simulator_label(name)}: {what}"
        for name in simulators
        for what in (r"$\tau$", "difference")
    ]
    return _latex(notes, ["", *heads], rows)


def _latex(notes: Sequence[str], *lines: Any) -> str:
    head, *parts = lines
    safe = [[[cell.replace("_", r"\_") for cell in row] for row in part] for part in parts]
    return latex(notes, [cell.replace("_", r"\_") for cell in head], *safe)


def _published(value: Published | None) -> str:
    if value is None:
        return "--"
    return f"{value.best_s:.1f}" + ("" if value.last_s is None else f" ({value.last_s:.1f})")


def _entry(row: Mapping[str, Any] | None) -> str:
    if row is None:
        return "--"
    mark = r"$^{*}$" if row["among_best"] else ""
    middle = f"{row['iqm']:.1f}{_ends(row['iqm_low'], row['iqm_high'], 1)}"
    return f"{row['median']:.1f}{mark}, {middle}"


def _agreement(row: Mapping[str, Any] | None) -> list[str]:
    if row is None:
        return ["--", "--"]
    tau = "--" if row["tau"] is None else f"{row['tau']:.2f}"
    difference = f"{100 * row['difference']:+.0f}\\,\\%".replace("-", "$-$")
    return [f"{tau}{_ends(row['tau_low'], row['tau_high'], 2)}", difference]


def _ends(low: float | None, high: float | None, digits: int) -> str:
    if low is None or high is None:
        return ""
    return rf" {{\scriptsize [{low:.{digits}f}, {high:.{digits}f}]}}".replace("[-", "[$-$")
