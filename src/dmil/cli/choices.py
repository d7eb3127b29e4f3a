"""What commands that run something share: scenario, simulator, reward, first start, Ctrl-C."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, Literal

from pydantic import BaseModel, Field

from dmil.cli.application import StoppedError
from dmil.cli.parameters import Option, options, settings_command, split
from dmil.cli.terminal import say, waiting
from dmil.compilation import is_cold
from dmil.demand.arrivals import DEFAULT_BATCH_VEH
from dmil.demand.sumo.acting import ACTING
from dmil.demand.sumo.remarks import LEFT_OUT, remarks_of
from dmil.errors import InputError
from dmil.experiments.warm_up import compile_kernels
from dmil.network.grid import ENTRY_LINK_TIME_S, LINK_TIME_S
from dmil.rewards import PAPER_CONSTANTS, Reward, RewardConstants, make_reward
from dmil.scenarios import Scenario
from dmil.scenarios.demand_changes import DemandChanges, changes_of
from dmil.scenarios.recipe import DynamicsChanges, GridChanges, ScenarioRecipe, TimingChanges
from dmil.simulation.stand_ins import stand_ins
from dmil.training import Policy

_DEMAND = "Demand (by default the scenario's own)"
_SIGNALS = "Signals and queues (by default the scenario's own)"


def _numbers(flag: str, example: str) -> Callable[[str], dict[str, str]]:
    """Return what reads an option such as ``E=5,N=5``; whether they are numbers, fields say."""

    def read(text: str) -> dict[str, str]:
        found: dict[str, str] = {}
        for part in split(text):
            key, equals, value = (each.strip() for each in part.rpartition("="))
            if not (key and equals and value):
                raise InputError(
                    f"found '{part}'", where=flag, expected=f"KEY=NUMBER, as {example}"
                )
            if key in found:
                raise InputError(f"'{key}' is given twice", where=flag, expected="one number")
            found[key] = value
        if not found:
            raise InputError(f"found '{text}'", where=flag, expected=f"KEY=NUMBER, as {example}")
        return found

    return read


_RATES, _PROFILE = "E=5,N=5,W=10,S=7", "0=0.5,1800=2,3600=0.5"
DEMAND_OPTIONS = (
    Option("demand.arrivals", "--arrivals", _DEMAND, "poisson|compound"),
    Option(
        "demand.batch_veh",
        "--batch",
        _DEMAND,
        help=f"Mean batch size of compound arrivals in vehicles; by default {DEFAULT_BATCH_VEH:g}.",
    ),
    Option(
        "demand.rate_veh_per_min",
        "--rates",
        _DEMAND,
        "NODE=X,NODE=X",
        read=_numbers("--rates", _RATES),
        help="Vehicles per minute per boundary node or side of a grid, such as "
        f"{_RATES}; nodes not named send none. Also replaces recorded vehicles.",
    ),
    Option(
        "demand.profile",
        "--profile",
        _DEMAND,
        "S=X,S=X",
        read=lambda text: list(_numbers("--profile", _PROFILE)(text).items()),
        help=f"Factor on the rates from each second on, starting at 0, such as {_PROFILE}.",
    ),
    Option("demand.profile_between", "--profile-between", _DEMAND, "step|linear"),
    Option("ties", "--ties", _DEMAND, "straight|coin"),
)
"""How random arrivals differ from a scenario's own."""

SCENARIO_OPTIONS = (
    *options(
        "Scenario",
        "scenario; roadnet FILE; flow FILE; net FILE; routes FILE,FILE; additional FILE,FILE; "
        "begin_s; phases program|derived; routing sumo|mesoscopic|free-flow; "
        "horizon_s --steps; load; resample; resample_shift_s; calibration FILE",
    ),
    *DEMAND_OPTIONS,
    *options(
        _SIGNALS,
        "timing.decision_interval_s; timing.clearance_s; timing.all_red_s; "
        "timing.clearance_kind KIND; timing.min_green_s; "
        "timing.max_green_s; timing.startup_lost_s; "
        "dynamics.saturation_flow_veh_per_s --saturation-flow; dynamics.storage; "
        "dynamics.vehicle_space_m; dynamics.gap_wait_s",
    ),
)

SIMULATOR_OPTIONS = options("Simulator", "simulator; emissions; ignore_junction_blocker_s")


class SimulatorChoice(BaseModel):
    """Which simulator runs a scenario."""

    simulator: Literal["queue", "sumo", "sumo-meso", "cityflow"] = Field(
        "queue",
        description="Simulator: queue (the embedded one), sumo (microscopic), sumo-meso, or "
        "cityflow (where its module is installed, for its files).",
    )
    emissions: bool = Field(
        False, description="Also let SUMO compute emissions and fuel, which takes longer."
    )


class RewardChoice(BaseModel):
    """What a learner gets."""

    reward: str = Field(
        "diffusion",
        description="Reward of learners: default, diffusion, entropy, queue, pressure, or "
        "module:function.",
    )
    reward_constants: RewardConstants = Field(
        PAPER_CONSTANTS, description="Constants of the reward default."
    )

    def make_reward(self) -> Reward:
        """Make it; an `InputError` if there is none of that name, or it has no such constants."""
        return make_reward(self.reward, self.reward_constants)


def with_scenario_of(recipe: ScenarioRecipe, policy: Policy | None) -> ScenarioRecipe:
    """Return the parts of a scenario, taken from a policy's training if none is named."""
    named = recipe.scenario or recipe.roadnet or recipe.flow or recipe.net or recipe.routes
    if named or policy is None or "recipe" not in policy.training:
        return recipe_of(recipe)
    trained = ScenarioRecipe(**policy.training["recipe"]).model_dump()
    given = recipe_of(recipe).model_dump(exclude_unset=True)
    return ScenarioRecipe(
        **{**trained, **given}
        | {
            table: trained[table] | {k: v for k, v in given.get(table, {}).items() if v is not None}
            for table in ("timing", "dynamics", "grid")
        }
        | {"demand": recipe.demand.over(DemandChanges(**trained["demand"]))}
    )


def recipe_of(settings: ScenarioRecipe) -> ScenarioRecipe:
    """Return the scenario's part of a command's settings."""
    names = settings.model_fields_set & set(ScenarioRecipe.model_fields)
    return ScenarioRecipe(**{name: getattr(settings, name) for name in names})


def files_as_settings(files: Sequence[str]) -> dict[str, Any]:
    """Return which parts of a scenario the files are that stand behind a command.

    For what they may be see `dmil.doctor.read_case`; an `InputError` if they make no scenario.
    """
    from dmil.doctor.arguments import SumoFilesGiven, sort_arguments

    given = sort_arguments(files)
    if isinstance(given, SumoFilesGiven):
        if given.configuration is not None:
            named = given.name or f"sumo:{given.configuration}"
            return {"scenario": named}
        found = {"net": given.network, "routes": given.routes, "additional": given.additional}
    elif given.name:
        return {"scenario": f"cityflow:{given.name}" if given.network else given.name}
    else:
        found = {"roadnet": given.network, "flow": given.flow}
    return {name: value for name, value in found.items() if value}


def complete_scenario(settings: ScenarioRecipe) -> dict[str, Any]:
    """Return what a scenario would fill in: horizon, signals, queues, demand, links."""
    if not (settings.scenario or settings.roadnet or settings.net):
        return {}
    grid = settings.grid
    if settings.scenario and settings.scenario.startswith("grid:"):
        usual = {"link_time_s": LINK_TIME_S, "entry_link_time_s": ENTRY_LINK_TIME_S}
        grid = GridChanges(**usual | settings.grid.model_dump(exclude_none=True))
    # Its own demand: what the load makes of it is told by the load.
    made = recipe_of(settings.model_copy(update={"load": 1.0})).build()
    own: Any = made.demand
    return {
        "horizon_s": made.horizon_s,
        "routing": made.sumo.routing if made.sumo else None,
        "timing": TimingChanges(**made.timing.model_dump()),
        "dynamics": DynamicsChanges(**made.dynamics.model_dump()),
        "demand": changes_of(own),
        "ties": getattr(own, "ties", None),
        "grid": grid,
    }


def scenario_command(
    name: str,
    kind: type[Any],
    options: tuple[Option, ...],
    complete: Callable[[Any], dict[str, Any]] | None = None,
) -> Callable[[Callable[[Any, bool], None]], Callable[..., None]]:
    """Turn a function of settings with a scenario into a command, see `settings_command`.

    ``complete`` says what the program would fill in later; by default all of scenario and
    controllers.
    """

    def completed(settings: Any) -> Any:
        return settings.model_copy(update=(complete or _complete)(settings))

    return settings_command(name, kind, options, complete=completed, files=files_as_settings)


def _complete(settings: Any) -> dict[str, Any]:
    changes, chosen = complete_scenario(settings), getattr(settings, "controller", None)
    if isinstance(chosen, tuple):
        changes["controller"] = tuple(each.complete() for each in chosen)
    elif chosen:
        changes["controller"] = chosen.complete()
    return changes


def built(recipe: ScenarioRecipe) -> Scenario:
    """Make the scenario; say which vehicles are left out, and what does not act on them."""
    made = recipe.build()
    for remark in remarks_of(made.demand):
        if remark.kind in ACTING or remark.kind in LEFT_OUT:
            what = remark.text.partition(";")[0]
            say(f"Warning: {remark.count} {what} (first '{remark.example}').")
    return made


def say_stand_ins(scenario: Scenario, simulator: str, controllers: Iterable[str]) -> None:
    """Say which intersections' own control the queue simulator cannot run."""
    if simulator == "queue" and "program" in controllers:
        for sentence in stand_ins(scenario.network):
            say(f"Warning: {sentence}.")


def compile_first() -> None:
    """Compile all kernels where this has not been done, and say so."""
    if is_cold():
        with waiting("First start: compiling kernels, once …"):
            compile_kernels()


@contextmanager
def stopping(text: str) -> Iterator[None]:
    """Let Ctrl-C end a command with what is kept, and how to go on."""
    try:
        yield
    except KeyboardInterrupt:
        raise StoppedError(text) from None
