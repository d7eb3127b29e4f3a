"""Pages from templates: what all of them know, and one look."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import jinja2
from markupsafe import Markup

from dmil.errors import unknown_name
from dmil.reports.export import embedded, script_bundle
from dmil.reports.figure import Figure
from dmil.reports.labels import controller_label, interval, number, signed
from dmil.reports.theme import DARK
from dmil.results import Results
from dmil.version import __version__


def environment(package: str | None = None) -> jinja2.Environment:
    """Return the templates that all pages use, and their filters.

    Parameters
    ----------
    package
        Package with templates of its own, beside its modules.
    """
    loaders = [jinja2.PackageLoader("dmil.reports")]
    if package:
        loaders.append(jinja2.PackageLoader(package, "."))
    made = jinja2.Environment(
        loader=jinja2.ChoiceLoader(loaders),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters |= {"number": number, "signed": signed, "controller": controller_label}
    made.filters["options_below"] = _options_below
    made.globals["interval"] = interval
    return made


def _options_below(label: str) -> Markup:
    """Return a contender's label with every option on a line of its own."""
    return Markup(",<br>").join(label.split(","))


def shared_values(results: Results, figures: Sequence[Figure]) -> dict[str, Any]:
    """Return what every page says about its study, and what its figures need."""
    return {
        "manifest": results.manifest,
        "version": __version__,
        "counts": results.query(
            "select count(*) runs, count(*) filter (status = 'ok') ok,"
            " any_value(status) filter (status <> 'ok') failure,"
            " min(horizon_s) shortest_s, max(horizon_s) longest_s from runs"
        ).row(0, named=True),
        "figures": figures,
        "specs": [(figure.name, embedded(figure.spec)) for figure in figures],
        "bundle": script_bundle(),
        "dark_colours": DARK,
    }


def check_preset(chosen: str | None, only: str) -> None:
    """Check the preset that is chosen of a study that has only one.

    Raises
    ------
    UnknownNameError
        It is another.
    """
    if chosen not in (None, only):
        raise unknown_name("preset in this study", str(chosen), [only])
