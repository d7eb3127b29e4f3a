"""Scenarios from CityFlow's files."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from dmil.demand import read_cityflow_flow
from dmil.errors import InputError, unknown_name
from dmil.network import read_cityflow_roadnet
from dmil.scenarios.model import FROM_FILES, CityflowFiles, QueueDynamics, Scenario, horizon_of
from dmil.scenarios.timing import PLAN, SignalTiming

DECISION_INTERVAL_S = 15


def cityflow_scenario(
    roadnet: str | Path,
    flow: str | Path,
    *,
    decision_interval_s: int = DECISION_INTERVAL_S,
    horizon_s: int | None = None,
    timing: SignalTiming | None = None,
    dynamics: QueueDynamics | None = None,
    name: str | None = None,
) -> Scenario:
    """Build a scenario from a road network and a flow file of CityFlow (ours).

    Parameters
    ----------
    roadnet, flow
        The two files.
    decision_interval_s
        Seconds between two decisions, unless ``timing`` is given.
    horizon_s
        Length of a run in seconds; if not given, the last departure rounded up to the next 600 s.
    timing
        Signal timing; if not given, clearance and greens are what each plan says.
    dynamics
        Queue dynamics; if not given 0.5 vehicles per second and lane, and finite storage.
    name
        Name of the scenario; if not given, ``cityflow:`` and the flow file's name.

    Raises
    ------
    InputError
        If a file is not valid, or the files do not belong together.
    """
    network = read_cityflow_roadnet(roadnet)
    demand = read_cityflow_flow(flow, network, horizon_s=horizon_s)
    if horizon_s is None:
        horizon_s = horizon_of(demand.last_departure_s)
    return Scenario(
        name=name or f"cityflow:{Path(flow).stem}",
        network=network,
        demand=demand,
        timing=timing or SignalTiming(decision_interval_s=decision_interval_s, **PLAN),
        dynamics=dynamics or QueueDynamics(**FROM_FILES),
        horizon_s=horizon_s,
        cityflow=CityflowFiles(Path(roadnet), demand.kinds),
    )


def find_cityflow_files(place: str) -> tuple[Path, Path]:
    """Find the road network and the flow file in a folder, or by ``FOLDER#FLOW_FILE`` (ours).

    Of several flow files the one is meant whose name all others continue, such as ``city.json``
    beside ``city_2000.json`` and ``city_2500.json``.

    Raises
    ------
    InputError
        If the folder does not hold them, or which flow file is meant is not clear.
    """
    folder, chosen = Path(place), ""
    if not folder.is_dir() and "#" in place:
        before, _, chosen = place.rpartition("#")
        folder = Path(before)
    wrong = partial(InputError, where=str(folder))
    if not folder.is_dir():
        raise wrong(
            "there is no such folder",
            expected="a folder with one roadnet*.json and one flow file",
            mend="check the path",
        )
    roadnets = sorted(folder.glob("roadnet*.json"))
    if len(roadnets) != 1:
        found = ", ".join(path.name for path in roadnets)
        raise wrong(
            f"there are {len(roadnets)} road networks: {found}" if found else "no road network",
            expected="exactly one file roadnet*.json",
            mend="use cityflow_scenario(roadnet, flow) to name both files"
            if found
            else "check that this is the right folder",
        )
    flows = {path.name: path for path in sorted(folder.glob("*.json")) if holds_list(path)}
    if chosen:
        if chosen not in flows:
            raise unknown_name("flow file", chosen, flows, where=str(folder))
        return roadnets[0], flows[chosen]
    return roadnets[0], _only_flow(folder, list(flows.values()))


def _only_flow(folder: Path, flows: list[Path]) -> Path:
    wrong = partial(InputError, where=str(folder))
    if not flows:
        raise wrong(
            "there is no flow file",
            expected="a JSON file with a list of vehicles beside the road network",
        )
    meant = [path for path in flows if all(other.stem.startswith(path.stem) for other in flows)]
    if len(meant) == 1:
        return meant[0]
    raise wrong(
        f"there are {len(flows)} flow files: {', '.join(path.name for path in flows)}",
        expected="one, or one whose name all others continue",
        mend=f"choose one, such as cityflow:{folder}#{flows[0].name}",
    )


def holds_list(path: Path) -> bool:
    """Tell whether a JSON file holds a list: a flow does, a network and a configuration do not."""
    with path.open("rb") as file:
        return file.read(256).lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"[")
