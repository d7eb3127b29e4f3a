"""Two versions beside each other: measured in turns, in processes of their own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

import dmil
from dmil.errors import DmilError, InputError


@dataclass(frozen=True, slots=True)
class Against:
    """A figure of this version and of another one.

    Attributes
    ----------
    name, unit: str
        What is measured.
    here, there: float
        Medians over the rounds.
    ratio, ratio_min, ratio_max: float
        Here over there, round by round: the median, and between which extremes it lay.
    """

    name: str
    unit: str
    here: float
    there: float
    ratio: float
    ratio_min: float
    ratio_max: float


def figures_against(
    folder: Path, *, rounds: int, progress: Callable[[int, int], None]
) -> list[Against]:
    """Measure this version and another one in turns; figures that only one has are left out.

    The folder is a checkout of the other version, or what its package ``dmil`` lies in. It runs
    with the packages that are installed here.

    Raises
    ------
    InputError
        There is no such package.
    DmilError
        A measurement failed.
    """
    other = _source_of(folder)
    mine = Path(dmil.__file__).parents[1]
    found: dict[Path, list[dict[str, dict[str, Any]]]] = {mine: [], other: []}
    progress(0, 2 * rounds)
    for done in range(2 * rounds):
        # Who begins changes from round to round, as the machine's speed does.
        source = (mine, other, other, mine)[done % 4]
        found[source].append(_measured(source))
        progress(done + 1, 2 * rounds)
    return [
        _compared(name, [each[name] for each in found[mine]], [each[name] for each in found[other]])
        for name in found[mine][0]
        if all(name in each for measured in found.values() for each in measured)
    ]


def _source_of(folder: Path) -> Path:
    for source in (folder / "src", folder):
        if (source / "dmil" / "__init__.py").is_file():
            return source.resolve()
    raise InputError(
        "there is no package dmil",
        where=str(folder),
        expected="a checkout of another version, with src/dmil in it",
    )


def _measured(source: Path) -> dict[str, dict[str, Any]]:
    environment = os.environ | {"PYTHONPATH": str(source)}
    command = [sys.executable, "-P", "-m", "dmil", "bench", "--json"]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        reason = done.stderr.strip().rpartition("\n")[2]
        raise DmilError(f"{source}: its bench ended with code {done.returncode}: {reason}")
    return {each["name"]: each for each in json.loads(done.stdout)["figures"]}


def _compared(name: str, here: list[dict[str, Any]], there: list[dict[str, Any]]) -> Against:
    mine, theirs = ([each["value"] for each in measured] for measured in (here, there))
    ratios = [one / other for one, other in zip(mine, theirs, strict=True)]
    unit, extremes = here[0]["unit"], (min(ratios), max(ratios))
    return Against(name, unit, median(mine), median(theirs), median(ratios), *extremes)
