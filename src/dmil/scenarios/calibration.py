"""What a run of SUMO has shown that the queue simulator should use."""

from __future__ import annotations

import hashlib
import json
from dataclasses import replace
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from dmil.errors import InputError
from dmil.files import write_text_atomically
from dmil.network import RoadNetwork
from dmil.network.json_file import first_problem
from dmil.scenarios.model import Scenario


class Calibration(BaseModel):
    """Numbers of the queue simulator measured in one run of SUMO (ours)."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    version: Literal[1] = Field(1, description="Version of this file's form.")
    scenario: str = Field(description="Scenario that was measured.")
    links_digest: str = Field(description="Digest of the ids of the network's links.")
    controller: str = Field(description="Controller in the run.")
    seed: int = Field(ge=0, description="Seed of the run.")
    saturation_flow_veh_per_s: float = Field(
        gt=0, description="Saturation flow of a standing queue, in vehicles per second and lane."
    )
    startup_lost_s: int = Field(ge=0, description="Start-up lost time in s, rounded.")
    start_wave_veh_per_s: float = Field(
        ge=0, description="Vehicles per second and lane that begin to move at green."
    )
    link_time_s: tuple[float, ...] = Field(
        description="Mean seconds of an undisturbed vehicle for every link, with the junction "
        "before it."
    )
    link_free_s: tuple[float, ...] = Field(
        description="Of these, the free-flow seconds, which do not count as delay."
    )
    headways: int = Field(ge=0, description="Headways behind standing queues that were measured.")
    passages: int = Field(ge=0, description="Undisturbed passages of links that were measured.")

    def applied_to(self, scenario: Scenario) -> Scenario:
        """Return a scenario whose queue simulator uses what was measured (ours).

        SUMO is not touched by it: it has its own drivers.

        Raises
        ------
        InputError
            If the scenario's network has other links.
        """
        if digest_of(scenario.network) != self.links_digest:
            raise InputError(
                f"it was measured on the links of '{self.scenario}', which are not those of "
                f"'{scenario.name}'",
                where="calibration",
                expected="a calibration of the same network",
                mend=f"measure one: dmil calibrate --scenario {scenario.name}",
            )
        return replace(
            scenario,
            dynamics=scenario.dynamics.model_copy(
                update={
                    "saturation_flow_veh_per_s": self.saturation_flow_veh_per_s,
                    "start_wave_veh_per_s": self.start_wave_veh_per_s,
                }
            ),
            timing=scenario.timing.model_copy(update={"startup_lost_s": self.startup_lost_s}),
            link_time_s=self.link_time_s,
            link_free_s=self.link_free_s,
        )

    def save(self, path: Path) -> None:
        """Write it as JSON, whole or not at all (ours).

        Raises
        ------
        OutputError
            If the file cannot be written.
        """
        write_text_atomically(path, self.model_dump_json(indent=1) + "\n")


def load_calibration(path: Path) -> Calibration:
    """Read a calibration (ours).

    Raises
    ------
    InputError
        If there is no such file, or it is none.
    """
    mend = "write one: dmil calibrate --scenario NAME --out FILE"
    try:
        values = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError("there is no such file", where=str(path), mend=mend) from None
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror})", where=str(path)) from None
    except ValueError as error:
        raise InputError(f"no JSON: {error}", where=str(path), mend=mend) from None
    try:
        return Calibration.model_validate(values)
    except ValidationError as error:
        place, problem = first_problem(error)
        raise InputError(
            problem,
            where=f"{path}: {place}" if place else str(path),
            expected="a calibration as dmil calibrate writes it",
            mend=mend,
        ) from None


def digest_of(network: RoadNetwork) -> str:
    """Return a digest of the links' ids in their order (ours)."""
    names = json.dumps([link.id for link in network.links])
    return hashlib.blake2b(names.encode(), digest_size=8).hexdigest()
