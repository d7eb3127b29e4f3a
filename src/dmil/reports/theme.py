"""One look for all figures: colours, fonts and sizes that stand up to a paper's column."""

from __future__ import annotations

from typing import Any

#: Widths of the plotting area in px. A figure made for one column of a two-column paper is printed
#: at about 3/4 of its size, so 11 px letters become 8 pt.
ONE_COLUMN = 260
PANEL = 170

FONT = "Liberation Sans, Arial, Helvetica, sans-serif"
INK, FAINT, GRID = "#222222", "#6b6b6b", "#e4e4e4"

#: Colours of the simulators.
SIMULATOR_COLOURS: dict[str, str] = {
    "SUMO": "#222222",
    "SUMO, mesoscopic": "#222222",
    "SUMO, blockers ignored": "#009E73",
    "queue, calibrated": "#0072B2",
    "queue": "#E69F00",
}

#: Colours of the rewards (Tol's palette).
REWARD_COLOURS: dict[str, str] = {
    "default": "#AA3377",
    "entropy": "#228833",
    "diffusion": "#CCAA22",
    "queue": "#4477AA",
    "pressure": "#EE6677",
}

PRESET_COLOURS: dict[str, str] = {
    "literal": "#66CCEE",
    "decaying": "#4477AA",
    "matched": "#222255",
}

DARK_BACKGROUND = "#0d1117"

#: Inks that a dark page needs lighter; all other colours stand on both.
DARK: dict[str, str] = {
    INK: "#e6e6e8",
    FAINT: "#a5a5ad",
    GRID: "#37373d",
    "#7a7a7a": "#a8a8a8",
    "#1F3B73": "#9db4e6",
    REWARD_COLOURS["default"]: "#d3609f",
    REWARD_COLOURS["entropy"]: "#3fae55",
    PRESET_COLOURS["matched"]: "#a9a9f0",
}

_SPARE = ("#4477AA", "#EE6677", "#228833", "#CCBB44", "#66CCEE", "#AA3377", "#777777")


def colours(names: list[str], table: dict[str, str]) -> list[str]:
    """Return the fixed colour of each name; names without one get spare colours in order."""
    spare = iter(_SPARE * (1 + len(names) // len(_SPARE)))
    return [table[name] if name in table else next(spare) for name in names]


def config() -> dict[str, Any]:
    """Return the Vega-Lite configuration of all figures."""
    return {
        "font": FONT,
        "background": "white",
        "padding": 4,
        "view": {"stroke": None},
        "title": {
            "font": FONT,
            "fontSize": 13,
            "fontWeight": 600,
            "anchor": "start",
            "color": INK,
            "offset": 8,
            "subtitleFont": FONT,
            "subtitleFontSize": 11,
            "subtitleColor": FAINT,
            "subtitlePadding": 4,
        },
        "axis": {
            "labelFont": FONT,
            "titleFont": FONT,
            "labelFontSize": 11,
            "titleFontSize": 11.5,
            "titleFontWeight": 400,
            "labelColor": INK,
            "titleColor": INK,
            "gridColor": GRID,
            "domainColor": FAINT,
            "tickColor": FAINT,
            "tickSize": 4,
            "titlePadding": 6,
        },
        "axisY": {"domain": False, "ticks": False, "labelPadding": 6},
        "header": {
            "labelFont": FONT,
            "labelFontSize": 11.5,
            "labelFontWeight": 600,
            "labelColor": INK,
            "labelPadding": 4,
            "titleFont": FONT,
            "titleFontSize": 11.5,
            "titleFontWeight": 400,
            "titleColor": FAINT,
        },
        "legend": {
            "labelFont": FONT,
            "titleFont": FONT,
            "labelFontSize": 11,
            "titleFontSize": 11,
            "titleFontWeight": 400,
            "labelColor": INK,
            "titleColor": FAINT,
            "labelLimit": 320,
            "symbolStrokeWidth": 0,
            "symbolSize": 70,
        },
        "facet": {"spacing": 14},
    }
