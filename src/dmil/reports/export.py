"""Charts and tables to files, offline: HTML, SVG, PNG, PDF, CSV, LaTeX; the figures of a report."""

from __future__ import annotations

import io
import json
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from importlib import metadata
from pathlib import Path
from typing import Any

import altair as alt
import polars as pl
import vl_convert

from dmil.compilation import user_cache_folder
from dmil.errors import OutputError
from dmil.files import write_atomically
from dmil.reports.drawing import PICTURE_FORMATS, draw
from dmil.reports.marks import Chart
from dmil.reports.theme import DARK, DARK_BACKGROUND, config

FORMATS = (*PICTURE_FORMATS, "html")

Specification = dict[str, Any]


def specification(chart: alt.TopLevelMixin) -> Specification:
    """Return the Vega-Lite specification of a chart with the house's look."""
    # The tests validate every figure; at run time it would cost more than drawing.
    built: Specification = chart.to_dict(validate=False)
    built["datasets"] = {
        name: json.loads(rows) if isinstance(rows, str) else rows
        for name, rows in built.get("datasets", {}).items()
    }
    built["config"] = config()
    return built


def picture(spec: Specification, format: str) -> bytes:
    """Return a chart in one of :data:`FORMATS`; html is interactive and holds all it needs."""
    if format == "html":
        page: str = vl_convert.vegalite_to_html(spec, bundle=True)
        return page.encode()
    return draw(spec, [format])[format]


def save_figure(chart: alt.TopLevelMixin | Specification, path: Path | str) -> Path:
    """Save a chart in the format that the ending of the path names.

    Raises
    ------
    OutputError
        The ending is none of svg, png, pdf, html, or the file cannot be written.
    """
    path = Path(path)
    format = path.suffix.removeprefix(".").lower()
    if format not in FORMATS:
        raise OutputError(
            f"cannot write a figure as '{path.suffix}'",
            where=str(path),
            expected=f"an ending of {', '.join('.' + name for name in FORMATS)}",
        )
    spec = chart if isinstance(chart, dict) else specification(chart)
    write_file(path, picture(spec, format))
    return path


def write_file(path: Path, content: str | bytes) -> None:
    """Write a file whole or not at all."""
    data = content.encode() if isinstance(content, str) else content

    def write(unfinished: Path) -> None:
        unfinished.write_bytes(data)

    write_atomically(path, write)


def embedded(spec: Specification) -> str:
    """Return a specification as JSON that may stand inside a script element."""
    return json.dumps(spec, separators=(",", ":"), ensure_ascii=False).replace("</", "<\\/")


def script_bundle() -> str:
    """Return Vega, Vega-Lite and Vega-Embed as one script; built once and then kept (1 s)."""
    kept = user_cache_folder() / f"vega-{metadata.version('vl-convert-python')}.js"
    with suppress(OSError):
        return kept.read_text(encoding="utf-8")
    built = str(vl_convert.javascript_bundle("window.vegaEmbed = vegaEmbed;")).replace(
        "</script", "<\\/script"
    )
    # Without a cache it is built every time, and nothing else is wrong.
    with suppress(OutputError):
        write_file(kept, built)
    return built


@dataclass(frozen=True, slots=True)
class Figure:
    """One figure of a report.

    Parameters
    ----------
    name
        Name of its files, without ending.
    section, scenario
        Part of the report it belongs to, and the scenario it shows, "" for all.
    caption
        What it shows and how to read it.
    spec
        Vega-Lite specification.
    """

    name: str
    section: str
    scenario: str
    caption: str
    spec: Specification


def figure(name: str, section: str, scenario: str, caption: str, chart: Chart) -> Figure:
    """Return a figure whose description, for those who cannot see it, is its caption."""
    spec = specification(chart)
    spec["description"] = caption
    return Figure(name, section, scenario, caption, spec)


Drawn = tuple[str, str, str, Chart | None]
"""Name, section, caption and chart of a figure, None if the runs do not allow it."""


def drawn_figures(drawn: Iterable[Drawn], scenario: str = "") -> Iterator[Figure]:
    """Yield the figures of a scenario that the runs allow, as they are made."""
    for name, section, caption, chart in drawn:
        if chart is not None:
            yield figure(name, section, scenario, caption, chart)


def darkened(made: Figure, section: str) -> Figure:
    """Return a figure, in another section, for dark pages, such as a code host shows at night."""
    text = json.dumps(made.spec)
    for light, dark in DARK.items():
        text = text.replace(f'"{light}"', f'"{dark}"')
    spec = json.loads(text)
    spec["config"]["background"] = DARK_BACKGROUND
    return replace(made, name=f"{made.name}-dark", section=section, spec=spec)


def slug(name: str) -> str:
    """Return a name as part of a file's name: "grid-5x5" for "grid:5x5"."""
    return "".join(letter if letter.isalnum() else "-" for letter in name)


def csv(table: pl.DataFrame) -> str:
    """Return a table as CSV; lists are left out."""
    flat = table.select(name for name, dtype in table.schema.items() if not dtype.is_nested())
    buffer = io.StringIO()
    flat.write_csv(buffer)
    return buffer.getvalue()


def evidence_csv(claims: pl.DataFrame) -> str:
    """Return the evidence of all claims, one comparison a row."""
    keys = [name for name in ("preset", "id") if name in claims.columns]
    table = claims.select(*keys, "evidence").explode("evidence").drop_nulls("evidence")
    return csv(table.unnest("evidence"))


def latex(
    notes: Sequence[str],
    head: Sequence[str],
    *parts: Iterable[Sequence[str]],
    left: int = 1,
) -> str:
    r"""Return a LaTeX tabular, for booktabs.

    Parameters
    ----------
    notes
        Comments above it.
    head, parts
        Its first line; its other lines, with a rule before each part that has some.
    left
        Columns that are set flush left.
    """
    lines = [f"% {note}" for note in notes]
    lines += [
        r"\begin{tabular}{" + "l" * left + "r" * (len(head) - left) + "}",
        r"\toprule",
        _line(head),
    ]
    for part in parts:
        rows = [_line(row) for row in part]
        lines += [r"\midrule", *rows] if rows else []
    return "\n".join([*lines, r"\bottomrule", r"\end{tabular}", ""])


def _line(cells: Sequence[str]) -> str:
    return " & ".join(cells) + r" \\"
