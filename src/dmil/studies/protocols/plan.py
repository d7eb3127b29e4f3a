"""The runs of the study of protocols."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from dmil.controllers.variants import Variant, parse_variant
from dmil.demand import FileDemand, Vehicles
from dmil.errors import InputError, unknown_name
from dmil.network import Intersection, Program
from dmil.scenarios import Scenario, cityflow_scenario
from dmil.seeding import stream
from dmil.studies.protocols.recipes import CITIES, PROTOCOLS, Protocol
from dmil.studies.protocols.rule import NAME
from dmil.studies.protocols.settings import ProtocolsStudySettings

CITYFLOW, QUEUE = "cityflow", "queue"


@dataclass(frozen=True, slots=True)
class ProtocolTrial:
    """One controller under one protocol in one simulator on one day; ``preset`` is the protocol."""

    preset: str
    scenario: str
    seed: int
    controller: Variant
    simulator: str


def trials(settings: ProtocolsStudySettings, *, cityflow: bool) -> list[ProtocolTrial]:
    """Return all trials; without CityFlow those in the queue simulator are all (ours).

    Raises
    ------
    InputError
        There is no such protocol, city or controller, or nothing can run.
    """
    variants = [parse_variant(text) for text in settings.controllers]
    for name in settings.protocols:
        if name not in PROTOCOLS:
            raise unknown_name("protocol", name, PROTOCOLS, where="protocols")
    simulators = [CITYFLOW] if cityflow else []
    simulators += [QUEUE] if settings.queue or not cityflow else []
    found = [
        ProtocolTrial(name, city, seed, variant, simulator)
        for name in settings.protocols
        for city in cities(settings)
        for seed in range(settings.first_seed, settings.first_seed + settings.seeds)
        for simulator in simulators
        for variant in variants
        if variant.name != NAME or simulator == CITYFLOW
    ]
    if not found:
        raise InputError(
            "no controller can run",
            where="controllers",
            expected=f"others than {NAME}, which needs CityFlow",
        )
    return found


def cities(settings: ProtocolsStudySettings) -> Sequence[str]:
    """Return the cities, by default all that are there; an `InputError` if one is not there."""
    for name in settings.cities:
        if name not in CITIES:
            raise unknown_name("city", name, CITIES, where="cities")
    wanted = settings.cities or tuple(CITIES)
    there = [name for name in wanted if all(each.is_file() for each in files(settings, name))]
    if not there or (settings.cities and len(there) < len(wanted)):
        missing = next(name for name in wanted if name not in there)
        absent = next(each for each in files(settings, missing) if not each.is_file())
        raise InputError(
            f"city {missing}: there is no file {absent}",
            where="data",
            expected="a folder with one folder per city in CityFlow's format",
            mend="give --data DIR, or set DMIL_DATA",
        )
    return there


def files(settings: ProtocolsStudySettings, city: str) -> tuple[Path, Path]:
    """Return road network and flow file of a city, whether or not they are there."""
    data = settings.data or Path()
    inner = data / "cityflow"
    name, flow = CITIES[city]
    folder = (inner if inner.is_dir() else data) / name
    roadnet = next(iter(sorted(folder.glob("roadnet*.json"))), folder / "roadnet.json")
    return roadnet, folder / flow


def build(settings: ProtocolsStudySettings, protocol: Protocol, city: str) -> Scenario:
    """Make the scenario of a city under a protocol (ours)."""
    made = cityflow_scenario(
        *files(settings, city), horizon_s=settings.horizon_s, timing=protocol.timing, name=city
    )
    if protocol.phases is None:
        return made
    items = tuple(first_phases(item, protocol.phases) for item in made.network.intersections)
    network = replace(made.network, intersections=items)
    assert isinstance(made.demand, FileDemand)
    return replace(made, network=network, demand=replace(made.demand, network=network))


def first_phases(item: Intersection, count: int) -> Intersection:
    """Return an intersection with its first phases only, its program without the others."""
    phases = item.phases[:count]
    stages = [] if item.program is None else item.program.stages
    kept = tuple(each for each in stages if each.clearance or each.green in phases)
    program = Program(kept) if kept else None
    return replace(item, phases=phases, phase_names=item.phase_names[:count], program=program)


def day(made: Scenario, seed: int, shift_s: int) -> Vehicles:
    """Return the recorded vehicles, for seeds above 0 each departure moved at random (ours)."""
    rng = stream(seed, "demand")
    vehicles = made.demand.vehicles(made.network, made.horizon_s, rng)
    if seed == 0 or not len(vehicles):
        return vehicles
    moved_s = vehicles.depart_s + rng.integers(-shift_s, shift_s + 1, len(vehicles))
    depart_s = np.clip(moved_s, 0, made.horizon_s - 1).astype(np.int32)
    order = np.argsort(depart_s, kind="stable")
    return replace(vehicles.take(order), depart_s=np.ascontiguousarray(depart_s[order]))
