"""Controllers by name: one plain table, and import paths for those of users."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel, ValidationError

from dmil.controllers.deep import on_demand
from dmil.controllers.deep.settings import (
    DqnSettings,
    HindsightSettings,
    NecSettings,
    PrioritisedSettings,
    VdnSettings,
)
from dmil.controllers.episodic.mfec import MfecController, MfecSettings
from dmil.controllers.episodic.plmp import PlmpController, PlmpSettings
from dmil.controllers.lanes.factored import FactoredController, FactoredSettings
from dmil.controllers.lanes.lookahead import LookaheadController, LookaheadSettings
from dmil.controllers.planner.foresight import ForesightController, ForesightSettings
from dmil.controllers.protocol import Controller
from dmil.controllers.rules.baselines import (
    ActuatedController,
    FixedCycleController,
    LongestQueueFirstController,
    MaxPressureController,
    ProgramController,
    RandomController,
)
from dmil.controllers.rules.gap_out import GapOutController, GapOutSettings
from dmil.controllers.rules.settings import (
    FixedCycleSettings,
    LongestQueueFirstSettings,
    MaxPressureSettings,
)
from dmil.controllers.rules.sotl import SotlController, SotlSettings
from dmil.controllers.rules.webster import WebsterController, WebsterSettings
from dmil.controllers.tabular.dual_memory import DualMemoryController
from dmil.controllers.tabular.prior import Prior
from dmil.controllers.tabular.sarsa import SarsaController
from dmil.controllers.tabular.settings import DualMemorySettings, SarsaSettings
from dmil.errors import InputError, unknown_name
from dmil.importing import import_object


@dataclass(frozen=True, slots=True)
class Entry:
    """A controller that has a name.

    Attributes
    ----------
    make
        Its class, or a function that loads it; takes the settings as first argument where it has
        some, and the keyword ``prior`` where it begins from one.
    settings
        Class of its settings, None if it has none.
    learns: bool
        Whether it has a memory to train.
    summary: str
        One line for people.
    from_prior: bool
        Whether it can begin from what a dummy agent learned.
    online: bool
        Whether it is meant to learn while it works, from the first second on, without training.
    """

    make: Any
    settings: type[BaseModel] | None
    learns: bool
    summary: str
    from_prior: bool = False
    online: bool = False


CONTROLLERS: dict[str, Entry] = {
    "random": Entry(RandomController, None, False, "uniformly random phases"),
    "fixed-cycle": Entry(
        FixedCycleController, FixedCycleSettings, False, "the same phases in the same order"
    ),
    "webster": Entry(
        WebsterController,
        WebsterSettings,
        False,
        "fixed cycle and splits from the run's mean flows (Webster 1958)",
    ),
    "program": Entry(ProgramController, None, False, "the network's own signal program"),
    "actuated": Entry(
        ActuatedController, None, False, "SUMO's actuated control of that program; in SUMO only"
    ),
    "gap-out": Entry(
        GapOutController, GapOutSettings, False, "actuated control: green while vehicles come"
    ),
    "sotl": Entry(
        SotlController, SotlSettings, False, "self-organising traffic lights (Gershenson 2005)"
    ),
    "longest-queue-first": Entry(
        LongestQueueFirstController,
        LongestQueueFirstSettings,
        False,
        "the phase with the most vehicles queued",
    ),
    "max-pressure": Entry(
        MaxPressureController,
        MaxPressureSettings,
        False,
        "the phase with the highest pressure (Varaiya 2013)",
    ),
    "foresight": Entry(
        ForesightController,
        ForesightSettings,
        False,
        "plans one intersection, all arrivals known: a limit, no rival",
    ),
    "factored": Entry(
        FactoredController,
        FactoredSettings,
        True,
        "factored dual memory: one small table of lanes, neighbours announce their phases",
        online=True,
    ),
    "lookahead": Entry(
        LookaheadController,
        LookaheadSettings,
        True,
        "model memory: a learned model of lanes, two decisions ahead",
        online=True,
    ),
    "sarsa": Entry(
        SarsaController,
        SarsaSettings,
        True,
        "the paper's non-memory agent, for any embedding",
        from_prior=True,
    ),
    "dual-memory": Entry(
        DualMemoryController,
        DualMemorySettings,
        True,
        "the paper's memory-based agent",
        from_prior=True,
    ),
    "mfec": Entry(
        MfecController, MfecSettings, True, "model-free episodic control (Blundell 2016)"
    ),
    "nec": Entry(
        on_demand("nec", "NecController"),
        NecSettings,
        True,
        "neural episodic control: a learned embedding over returns (Pritzel 2017)",
    ),
    "plmp": Entry(
        PlmpController,
        PlmpSettings,
        True,
        "pattern learning with memory and prediction (Han 2023), reconstructed",
    ),
    "dqn": Entry(
        on_demand("dqn", "DqnController"),
        DqnSettings,
        True,
        "deep Q-network with experience replay (Mnih 2015)",
    ),
    "dqn-prioritised": Entry(
        on_demand("dqn_prioritised", "PrioritisedController"),
        PrioritisedSettings,
        True,
        "the same with prioritised replay (Schaul 2016)",
    ),
    "dqn-hindsight": Entry(
        on_demand("dqn_hindsight", "HindsightController"),
        HindsightSettings,
        True,
        "the same with goals and hindsight replay (Andrychowicz 2017); an ablation",
    ),
    "vdn": Entry(
        on_demand("vdn", "VdnController"),
        VdnSettings,
        True,
        "value decomposition network: one error on the sum of all values (Sunehag 2018)",
    ),
}
"""The named controllers."""


def check_controller(name: str, *, where: str | None = None) -> None:
    """Check a controller's name; whether an import path leads to one shows when it is made (ours).

    Parameters
    ----------
    name, where
        The name, and the file or option it came from.

    Raises
    ------
    UnknownNameError
        There is no such controller.
    """
    if ":" not in name and name not in CONTROLLERS:
        raise unknown_name("controller", name, CONTROLLERS, where=where)


def make_controller(
    name: str, options: Mapping[str, object] | None = None, *, prior: Prior | None = None
) -> Controller:
    """Make a controller from its name or import path and its options (ours).

    Parameters
    ----------
    name
        A name of `CONTROLLERS`, or ``package.module:Class`` for one of your own: it is called with
        the options as keywords.
    options
        Values for the fields of the controller's settings.
    prior
        What a learner starts from; controllers that have no use for it ignore it.

    Raises
    ------
    InputError
        If there is no such controller or an option is wrong.
    """
    options = dict(options or {})
    if ":" in name:
        return _own_controller(name, options)
    check_controller(name)
    entry = CONTROLLERS[name]
    if entry.settings is None:
        if options:
            raise InputError(
                f"it has no option '{sorted(options)[0]}'",
                where=f"controller '{name}'",
                expected="no options",
            )
        made: Controller = entry.make()
        return made
    settings = make_settings(entry.settings, options, where=f"controller '{name}'")
    made = entry.make(settings, prior=prior) if entry.from_prior else entry.make(settings)
    return made


def make_settings(kind: type[BaseModel], options: Mapping[str, object], *, where: str) -> BaseModel:
    """Validate options into settings, with one clear error (ours).

    Raises
    ------
    InputError
        If an option does not exist or its value cannot be used.
    """
    known = set(kind.model_fields)
    for option in options:
        if option not in known:
            raise unknown_name("option", option, known, where=where)
    try:
        return kind(**options)
    except ValidationError as error:
        first = error.errors()[0]
        raise InputError(
            f"{first['loc'][0]} = {first['input']!r}", where=where, expected=_expected(first["msg"])
        ) from None


def _expected(message: str) -> str:
    for start in ("Input should be ", "Value error, "):
        message = message.removeprefix(start)
    return message


def _own_controller(path: str, options: Mapping[str, object]) -> Controller:
    kind = import_object(path, "controller")
    try:
        made = kind(**options)
    except TypeError as error:
        raise InputError(
            f"it cannot be made ({error})",
            where=f"controller '{path}'",
            expected="a class that takes its options as keywords",
        ) from error
    if not isinstance(made, Controller):
        raise InputError(
            f"{type(made).__name__} lacks the verbs of a controller",
            where=f"controller '{path}'",
            expected="methods begin(situation) and decide(observation, reward)",
        )
    return made
