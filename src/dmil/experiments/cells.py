"""Where a study runs: a network with its demand, on grids, recorded cities and SUMO's roads."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from dmil.demand import FileDemand, ResampledDemand
from dmil.errors import InputError
from dmil.scenarios import Scenario, SignalTiming, scenario
from dmil.scenarios.cityflow import holds_list

CITY = "cityflow:"
"""What the name of a city's scenario begins with; its folder's name follows."""
CITY_TIMING = SignalTiming(decision_interval_s=15, clearance_s=5)
"""As users of CityFlow judge controllers: a decision every 15 s, its first 5 s yellow."""


@dataclass(frozen=True, slots=True)
class Cell:
    """A network with its demand.

    Attributes
    ----------
    scenario: str
        Name of the scenario; a city's is that of its folder inside the folder of data.
    load: float
        Factor on its demand.
    """

    scenario: str
    load: float = 1.0

    @classmethod
    def parse(cls, name: str) -> Cell:
        """Read a cell's name, such as ``grid:5x5`` or ``grid:5x5*3.6`` (ours).

        Raises
        ------
        InputError
            The load is not a number.
        """
        place, star, load = name.partition("*")
        try:
            return cls(place, float(load) if star else 1.0)
        except ValueError:
            raise InputError(
                f"found '{name}'",
                where="cells",
                expected="SCENARIO or SCENARIO*LOAD, such as grid:5x5*3",
            ) from None

    @property
    def name(self) -> str:
        """Its name, as `parse` reads it."""
        return self.scenario if self.load == 1.0 else f"{self.scenario}*{self.load:g}"

    def build(self, horizon_s: int, data: Path | None) -> Scenario:
        """Make the scenario; ``data`` is the folder of the cities' folders (ours).

        Raises
        ------
        InputError
            There is no such scenario, its files are not valid, or a city has no folder of data.
        """
        if not self.scenario.startswith(CITY):
            return scenario(self.scenario, horizon_s=horizon_s, load=self.load)
        place = city_folder(data) / self.scenario.removeprefix(CITY)
        city = scenario(f"{CITY}{place}", horizon_s=horizon_s, load=self.load, timing=CITY_TIMING)
        assert isinstance(city.demand, FileDemand)
        # One recorded day is one number; seeds are other days like it.
        return replace(city, demand=ResampledDemand(city.demand))


def city_folder(data: Path | None) -> Path:
    """Return the folder of the cities' folders: the one given, or ``cityflow`` in it (ours).

    Raises
    ------
    InputError
        None was given, or it is no folder.
    """
    expected = "a folder with one folder per city, in CityFlow's format"
    if data is None:
        mend = "add --data DIR, or set DMIL_DATA"
        raise InputError("no data folder was given", where="cells", expected=expected, mend=mend)
    inner = data / "cityflow"
    folder = inner if inner.is_dir() else data
    if not folder.is_dir():
        mend = "check --data or DMIL_DATA"
        raise InputError("there is no such folder", where=str(data), expected=expected, mend=mend)
    return folder


def city_cells(data: Path) -> tuple[str, ...]:
    """Return the names of the cells in a folder of data: every city with its first flow (ours).

    The first is that with whose name those of all others begin, or the first by name.

    Raises
    ------
    InputError
        There is no such folder, or no city in it.
    """
    folder = city_folder(data)
    found = []
    for city in sorted(path.parent for path in folder.glob("*/roadnet*.json")):
        flows = sorted(path.stem for path in city.glob("*.json") if holds_list(path))
        if flows:
            alone = all(other.startswith(flows[0]) for other in flows)
            found.append(f"{CITY}{city.name}" + ("" if alone else f"#{flows[0]}.json"))
    if not found:
        raise InputError(
            "it holds no city",
            where=str(folder),
            expected="one folder per city with roadnet*.json and flow files",
        )
    return tuple(found)
