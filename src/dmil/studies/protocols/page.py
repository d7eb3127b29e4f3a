"""The report of the study of protocols: one page, its tables as files."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from dmil.analysis.panel import rows_by
from dmil.reports.contenders import controller_name
from dmil.reports.export import Figure, csv
from dmil.reports.html import check_preset, configuration_rows, environment, shared_values
from dmil.reports.labels import simulator_label
from dmil.results import Results
from dmil.results.metrics import METRICS
from dmil.studies.protocols.figures import figures_of_study
from dmil.studies.protocols.plan import CITYFLOW
from dmil.studies.protocols.published import SOURCE
from dmil.studies.protocols.recipes import PROTOCOLS
from dmil.studies.protocols.tables import METHOD, RULE, ProtocolsTables, protocols_tables

CSV = "ours", "published", "split", "agreement"


class ProtocolsReport:
    """What the report of the study is made of: a `dmil.studies.registry.Report`."""

    def __init__(
        self, results: Results, tables: ProtocolsTables | None = None, preset: str | None = None
    ) -> None:
        check_preset(preset, "protocols")
        self._results = results
        self._tables = tables or protocols_tables(results)

    def tables(self) -> dict[str, str | bytes]:
        """Return the tables' files by name."""
        return {f"tables/{name}.csv": csv(getattr(self._tables, name)) for name in CSV}

    def figures(self) -> Iterator[Figure]:
        """Yield the figures as they are made."""
        yield from figures_of_study(self._tables)

    def pages(self, figures: list[Figure]) -> dict[str, str]:
        """Return the page by its name."""
        values = shared_values(self._results, figures) | self._values()
        page = environment(__package__).get_template("page.html.j2")
        return {"report.html": page.render(values)}

    def _values(self) -> dict[str, Any]:
        made = self._tables
        configuration = self._results.manifest.get("configuration", {})
        parts = made.ours.select("preset", "simulator", "measure").unique(maintain_order=True)
        controllers = made.ours["controller"].unique(maintain_order=True).to_list()
        seeds = self._results.query("select distinct seed from runs order by seed")
        return {
            "protocols": PROTOCOLS,
            "parts": parts.rows(),
            "cities": {
                name: group["scenario"].unique(maintain_order=True).to_list()
                for (name,), group in made.ours.group_by("preset", maintain_order=True)
            },
            "controllers": controllers,
            "names": {name: controller_name(name) for name in (*controllers, RULE, METHOD)},
            "ours": rows_by(made.ours, "preset", "simulator", "controller", "scenario"),
            "methods": made.published.select("preset", "method").unique(maintain_order=True).rows(),
            "published": rows_by(made.published, "preset", "method", "scenario"),
            "source": SOURCE,
            "split": made.split.rows(named=True),
            "agreement": made.agreement.rows(named=True),
            "has_cityflow": CITYFLOW in made.ours["simulator"],
            "labels": {name: each.label for name, each in METRICS.items()},
            "simulator_labels": {name: simulator_label(name) for _, name, _ in parts.rows()},
            "rule": RULE,
            "method": METHOD,
            "shift_s": configuration.get("shift_s"),
            "seeds": seeds["seed"].to_list(),
            "configuration": configuration_rows(configuration),
        }


REPORT = ProtocolsReport
"""What makes the report of such a study."""
