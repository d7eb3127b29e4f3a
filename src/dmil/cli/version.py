"""``dmil version``."""

from __future__ import annotations

import platform
from importlib import metadata

from dmil.cli.options import Debug, Json
from dmil.cli.terminal import print_json, show
from dmil.version import __version__

PACKAGES = (
    "numpy",
    "numba",
    "scipy",
    "pydantic",
    "polars",
    "duckdb",
    "altair",
    "vl-convert-python",
)
EXTRAS = {
    "deep": ("torch",),
    "ray": ("ray",),
    "sumo": ("eclipse-sumo", "libsumo", "sumolib", "sumo-rl"),
    "tune": ("optuna",),
    "zoo": ("gymnasium", "pettingzoo"),
}
"""Optional extras and the packages that make each."""


def version(json: Json = False, debug: Debug = False) -> None:
    """Print the versions of dmil, Python, its dependencies and installed extras.

    Include them in bug reports. A study records them in its manifest.
    """
    found = {"dmil": __version__, "python": platform.python_version()}
    packages = {name: version for name in PACKAGES if (version := _version(name))}
    extras = {name: all(map(_version, needs)) for name, needs in EXTRAS.items()}
    if json:
        print_json({**found, **packages, "extras": extras})
        return
    width = max(map(len, packages))
    for name, number in {**found, **packages}.items():
        show(f"{name:{width}}  {number}")
    for name, there in extras.items():
        mend = f"not installed: pip install 'dmil[{name}]'"
        show(f"{'extra ' + name:{width}}  {'installed' if there else mend}")


def _version(package: str) -> str | None:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None
