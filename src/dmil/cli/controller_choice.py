"""Which controllers: one or several, policies, tuned ones, baselines and the reference."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from dmil.cli.choices import RewardChoice, SimulatorChoice
from dmil.cli.parameters import JOBS, Option, set_option
from dmil.cli.terminal import say
from dmil.controllers import CONTROLLERS, RECOMMENDED, check_controller, make_settings
from dmil.controllers.variants import Variant, parse_variant
from dmil.errors import InputError
from dmil.experiments.comparison import REFERENCE
from dmil.experiments.contender import Contender, accepted
from dmil.experiments.tuning import load_tuned
from dmil.scenarios import Scenario
from dmil.scenarios.recipe import ScenarioRecipe
from dmil.seeding import LARGEST_SEED
from dmil.training import Policy, load_policy

DEFAULT_CONTROLLER = "max-pressure"


def controller_options(many: bool) -> tuple[Option, ...]:
    """Return the options that name one controller, or many, and change its settings."""
    panel = "Controllers" if many else "Controller"

    def named(given: Any) -> Any:
        return [_named(text) for text in given] if many else _named(given)

    return (
        Option("controller", "--controller", panel, read=named, many=many),
        set_option(
            panel,
            path="changes" if many else "controller",
            help="Setting of the controller, such as embedding=complex or epsilon=0.2 (see "
            "'dmil controllers NAME').",
            example="grid.link_time_s=3",
        ),
    )


class ControllerChoice(BaseModel):
    """A controller and its options, which stand beside its name."""

    model_config = ConfigDict(frozen=True, extra="allow")

    name: str = Field(
        description="Name (see dmil controllers) or package.module:Class; with options as in "
        "NAME,option=value."
    )

    @model_validator(mode="before")
    @classmethod
    def _named(cls, value: Any) -> Any:
        if isinstance(value, dict) and ":" not in str(value.get("name", ":")):
            return value | {"name": str(value["name"]).lower()}
        return _named(value) if isinstance(value, str) else value

    @property
    def changed(self) -> dict[str, Any]:
        """Its options that are not the defaults."""
        entry = CONTROLLERS.get(self.name)
        usual = entry.settings().model_dump() if entry and entry.settings else {}
        return {k: v for k, v in self.options.items() if k not in usual or usual[k] != v}

    @property
    def label(self) -> str:
        """Its name and the options that are not its defaults, in one word."""
        return Variant(self.name, self.changed).label

    @property
    def options(self) -> dict[str, Any]:
        """Its options."""
        return dict(self.model_extra or {})

    def complete(self) -> ControllerChoice:
        """Return the same with all options of a named controller, defaults included."""
        entry = CONTROLLERS.get(self.name)
        if entry is None or entry.settings is None:
            return self
        where = f"controller '{self.name}'"
        settings = make_settings(entry.settings, self.options, where=where)
        return ControllerChoice(**{"name": self.name, **settings.model_dump()})

    @property
    def meanings(self) -> dict[str, str]:
        """What the options of a named controller mean."""
        entry = CONTROLLERS.get(self.name)
        fields = entry.settings.model_fields if entry and entry.settings else {}
        return {name: field.description or "" for name, field in fields.items()}


def _named(text: str) -> dict[str, Any]:
    variant = parse_variant(text)
    return {"name": variant.name, **variant.options}


Controllers = Annotated[
    tuple[ControllerChoice, ...],
    BeforeValidator(lambda value: value if isinstance(value, list | tuple) else [value]),
]
"""Several of them; a file may name one alone."""


class ControllerOrPolicy(BaseModel):
    """Who runs alone: a controller, or the policy of one."""

    controller: ControllerChoice = Field(
        ControllerChoice(name=DEFAULT_CONTROLLER),
        description="Controller: a name (see dmil controllers) or package.module:Class.",
    )
    policy: Path | None = Field(
        None, description="Policy of a trained controller instead; it runs frozen and greedy."
    )

    def load_policy(self, mend: str = "leave out --policy or --controller") -> Policy | None:
        """Read the policy where one is given.

        An `InputError` if it cannot be read, or another controller is named, too.
        """
        policy = load_policy(self.policy) if self.policy else None
        if policy and self.controller.name not in (DEFAULT_CONTROLLER, policy.controller):
            raise InputError(
                f"controller '{self.controller.name}' beside a policy of '{policy.controller}'",
                where=str(self.policy),
                expected="one of the two",
                mend=mend,
            )
        return policy

    def contender(self, policy: Policy | None) -> Contender:
        """Return who runs: the policy, frozen, or the controller as it is."""
        choice = self.controller
        if policy and self.policy:
            return Contender.trained(self.policy, policy, choice.options)
        return Contender(choice.label, Variant(choice.name, choice.options))


GRID = "grid:"
GRID_BASELINES = ("fixed-cycle", "longest-queue-first", "max-pressure")
"""What stands beside on a grid, as in the paper."""
BASELINES = (
    "longest-queue-first,approaching=true",
    "max-pressure,approaching=true",
    RECOMMENDED,
    "factored",
    "lookahead",
)
"""What stands beside a network's own plan: what is hard to beat, and needs no training."""
REFERENCES = ("program", REFERENCE, "max-pressure,approaching=true")
"""Default references for paired differences: the first that is available."""


class EvaluateParameters(ScenarioRecipe, SimulatorChoice, RewardChoice):
    """A comparison."""

    controller: Controllers = Field((), description="Controller to evaluate; may be repeated.")
    policy: tuple[Path, ...] = Field((), description="Policy to evaluate; may be repeated.")
    tuned: tuple[Path, ...] = Field(
        (), description="Controller to evaluate with the options from dmil tune; may be repeated."
    )
    changes: dict[str, Any] = Field(
        {}, description="Settings that override those of all evaluated controllers and policies."
    )
    seeds: int = Field(10, ge=1, description="Number of test seeds.")
    seed: int = Field(0, ge=0, le=LARGEST_SEED, description="First seed.")
    baselines: bool = Field(
        True,
        description="Add the network's own plan, actuated control (in SUMO), longest-queue-first "
        "and max-pressure with approaching vehicles, combined, factored and lookahead; on "
        "grids fixed-cycle, longest-queue-first and max-pressure.",
    )
    reference: str | None = Field(
        None,
        description="Reference for paired differences: a controller, added if missing, or the "
        "file name of a policy; by default the network's own plan, or max-pressure.",
    )
    learn: bool = Field(
        False, description="Let learners keep learning and exploring during the test."
    )
    epsilon: float | None = Field(
        None,
        ge=0,
        le=1,
        description="Probability of a random action; by default 0 when frozen, else the "
        "learner's own.",
    )
    report: Path | None = Field(
        None, description="Write the comparison as a page (.html) with a map of the network."
    )
    csv: Path | None = Field(None, description="Write the values of every seed, one row per run.")
    jobs: int | None = JOBS


def baselines_of(scenario: Scenario, simulator: str) -> tuple[str, ...]:
    """Return who stands beside by default.

    On a network from files that is its own plan, or a fixed cycle where it has none; only SUMO can
    show a plan under actuated control.
    """
    if scenario.name.startswith(GRID):
        return GRID_BASELINES
    items = scenario.network.intersections
    planned = all(item.program or item.own_control for item in items)
    # Where a control that only SUMO can run is all there is, nothing is left of the plan elsewhere.
    if not planned or (simulator == "queue" and not any(item.program for item in items)):
        return ("fixed-cycle", *BASELINES)
    actuated = () if simulator == "queue" else ("actuated",)
    return ("program", *actuated, *BASELINES)


def contenders_of(
    settings: EvaluateParameters, policies: list[Policy], scenario: Scenario
) -> tuple[list[Contender], str]:
    """Return everyone who runs, each with a label of its own, and the reference's label.

    An `InputError` if there is no such controller, or a tuned file or the reference cannot be used.
    """
    made: dict[str, Contender] = {}

    def add(label: str, variant: Variant, **contender: Any) -> None:
        unique, count = label, 2
        while unique in made:
            unique, count = f"{label} ({count})", count + 1
        made[unique] = Contender(unique, variant, **contender)

    def with_changes(label: str) -> str:
        return Variant(label, settings.changes).label

    settings.make_reward()
    own = {"reward": settings.reward, "reward_constants": settings.reward_constants}
    mode = _mode(settings)
    for path, policy in zip(settings.policy, policies, strict=True):
        options = accepted(policy.controller, mode) | settings.changes
        learned = {"reward": policy.reward, "reward_constants": policy.reward_constants}
        variant = Variant(policy.controller, options)
        add(with_changes(path.name), variant, policy=str(path), **learned)
    for choice in settings.controller:
        check_controller(choice.name)
        # What freezes a learner goes over its defaults, not over what somebody asked for.
        frozen = choice.options | _untrained(choice.name, mode)
        options = frozen | choice.changed | settings.changes
        label = Variant(choice.name, choice.changed | settings.changes).label
        add(label, Variant(choice.name, options), **own)
        _warn_of_nothing_learned(label, options)
    for path in settings.tuned:
        tuned = load_tuned(path)
        options = tuned.chosen | _untrained(tuned.controller, mode) | settings.changes
        its = {"reward": tuned.reward, "reward_constants": tuned.reward_constants}
        add(with_changes(f"{tuned.label} tuned"), Variant(tuned.controller, options), **its)
        _warn_of_nothing_learned(tuned.label, options, path)
    for text in baselines_of(scenario, settings.simulator) if settings.baselines else ():
        if text not in made:
            add(text, parse_variant(text))
    reference = next((each for each in REFERENCES if each in made), REFERENCE)
    if settings.reference is not None:
        reference = _reference_label(settings.reference, list(made))
        if reference not in made:
            add(reference, _reference(reference, mode, list(made)), **own)
    return list(made.values()), reference


def _warn_of_nothing_learned(
    label: str, options: dict[str, Any], tuned: Path | None = None
) -> None:
    if options.get("learning") is False:
        train = "train it" if tuned is None else f"train it (dmil train --tuned {tuned})"
        say(f"{label} has learned nothing yet and is frozen: {train}, or add --learn.")


def _reference_label(wanted: str, made: list[str]) -> str:
    """Return who is meant: a label as it stands, or a policy by its file, or a controller."""
    if wanted in made:
        return wanted
    file = Path(wanted).name
    policies = [label for label in made if label.partition(",")[0] == file]
    return policies[0] if policies else parse_variant(wanted).label


def _reference(wanted: str, mode: dict[str, Any], made: list[str]) -> Variant:
    variant = parse_variant(wanted)
    if ":" not in variant.name and variant.name not in CONTROLLERS:
        raise InputError(
            f"found '{wanted}'",
            where="--reference",
            expected=f"one of {', '.join(dict.fromkeys([*made, *CONTROLLERS]))}",
        )
    return Variant(variant.name, _untrained(variant.name, mode) | dict(variant.options))


def _untrained(name: str, mode: dict[str, Any]) -> dict[str, Any]:
    """Return what a controller takes of a mode that learned nothing yet; some need no training."""
    entry = CONTROLLERS.get(name)
    return {} if entry is not None and entry.online else accepted(name, mode)


def _mode(settings: EvaluateParameters) -> dict[str, Any]:
    """Return the options that freeze a learner, or let it learn."""
    mode: dict[str, Any] = {"learning": settings.learn}
    if settings.epsilon is not None:
        mode["epsilon"] = settings.epsilon
    elif not settings.learn:
        mode["epsilon"] = 0.0
    return mode
