"""``dmil train``: run episodes and save the policy after each."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from pydantic import Field

from dmil.cli.application import StoppedError
from dmil.cli.choices import (
    SCENARIO_OPTIONS,
    SIMULATOR_OPTIONS,
    RewardChoice,
    SimulatorChoice,
    built,
    compile_first,
    recipe_of,
    scenario_command,
    stopping,
)
from dmil.cli.controller_choice import ControllerChoice, controller_options
from dmil.cli.parameters import Option, options
from dmil.cli.terminal import number, print_json, say, show, waiting
from dmil.cli.train_verdict import as_json, judged, verdict
from dmil.controllers import CONTROLLERS, RECOMMENDED, MemoryController, make_controller
from dmil.errors import InputError
from dmil.experiments.comparison import Comparison
from dmil.experiments.tuning import load_tuned
from dmil.scenarios import Scenario
from dmil.scenarios.recipe import ScenarioRecipe
from dmil.seeding import LARGEST_SEED
from dmil.simulation import make_simulator
from dmil.training import (
    Policy,
    Run,
    controller_of,
    load_policy,
    policy_of,
    save_policy,
    train_prior,
)
from dmil.training import train as train_episodes
from dmil.training.episodes import EpisodeRecorder, TrainingLog

UNKNOWN = "Not compared yet: rules and memories without training may be better. Compare with:"


class TrainParameters(ScenarioRecipe, SimulatorChoice, RewardChoice):
    """A training."""

    controller: ControllerChoice = Field(
        ControllerChoice(name=RECOMMENDED),
        description="Controller that learns: a name (see dmil controllers) or "
        "package.module:Class.",
    )
    tuned: Path | None = Field(
        None, description="Train the controller of a dmil tune file with the options chosen for it."
    )
    episodes: int = Field(
        10, ge=1, description="Training runs, those of a resumed policy included."
    )
    seed: int = Field(
        0, ge=0, le=LARGEST_SEED, description="Master seed of demand and exploration."
    )
    prior: bool = Field(
        True,
        description="Start from the Q-table that exact SARSA (ε = 0.1) learns in one run, the "
        "dummy agent of the paper's training phase; for sarsa and dual-memory.",
    )
    compare: bool = Field(
        True,
        description="Finally compare the policy with controllers that need no training, in the "
        "queue simulator.",
    )
    out: Path | None = Field(
        None, description="Policy file, .npz; with --resume by default the resumed one."
    )
    log: Path | None = Field(
        None,
        description="Write a row for each episode as it ends: .csv or .jsonl; without an ending a "
        "folder for TensorBoard. --resume goes on with it.",
    )
    resume: Path | None = Field(
        None,
        description="Resume the training of this policy with its scenario, controller and seed.",
    )


OPTIONS = (
    *SCENARIO_OPTIONS,
    SIMULATOR_OPTIONS[0],
    *controller_options(many=False),
    Option("tuned", "--tuned", "Controller", "FILE"),
    *options("Training", "reward; episodes; seed; prior; resume FILE"),
    *options("Output", "compare; out FILE; log FILE"),
)


@scenario_command("train", TrainParameters, OPTIONS)
def train(settings: TrainParameters, json: bool) -> None:
    """Train a controller and save its policy to a file.

    For example:
        dmil train --scenario grid:3x3 --out policy.npz
        dmil train --scenario grid:3x3 --controller dual-memory --out dual.npz
        dmil train --roadnet roadnet.json --flow flow.json --out city.npz
        dmil train --resume policy.npz --episodes 20
        dmil evaluate --policy policy.npz

    Each episode is one run with its own demand and exploration; the memory is kept between
    episodes. After each one the policy is saved, and a line shows travel time and wait per vehicle
    in s, W/V_c, and memory entries per intersection. These numbers include exploration: use
    evaluate to assess the policy.

    The last lines compare the policy with rules and memories that need no training: often these are
    better. (Not with --simulator sumo: use evaluate there.)

    Ctrl-C keeps the last finished episode. Resumed training gives the same bytes as uninterrupted
    training.
    """
    before = load_policy(settings.resume) if settings.resume else None
    if before is not None and settings.resume is not None:
        settings = _resumed(settings, before, str(settings.resume))
    elif settings.tuned is not None:
        settings = _as_tuned(settings, settings.tuned)
    out = settings.out or settings.resume
    if out is None:
        raise InputError(
            "no file for the policy", where="--out", mend="add for example: --out policy.npz"
        )
    scenario = built(recipe_of(settings))
    reward = settings.make_reward()
    simulator = make_simulator(scenario, settings.simulator)
    done = int(before.training["episodes"]) if before else 0
    options = settings.controller.complete().options
    controller = _checked(settings, options)
    # A row may be in the log whose policy is not saved yet: --resume writes it anew.
    log = [TrainingLog(settings.log, done)] if settings.log else []
    compile_first()
    entry = CONTROLLERS.get(settings.controller.name)
    if before is not None:
        controller = controller_of(before, scenario.network, where=str(settings.resume))
    elif settings.prior and entry is not None and entry.from_prior:
        with waiting("pretraining the Q-table"):
            announced = bool(options.get("announced", False))
            prior = train_prior(
                scenario, reward, settings.seed, announced=announced, simulator=simulator
            )
        made = make_controller(settings.controller.name, options, prior=prior)
        assert isinstance(made, MemoryController)
        controller = made

    keeper = _Keeper(settings, scenario, out, say if json else show)
    rows = keeper.rows
    try:
        train_episodes(
            scenario,
            controller,
            reward,
            settings.seed,
            episodes=range(done, settings.episodes),
            observers=[*log, keeper],
            simulator=simulator,
        )
    except KeyboardInterrupt:
        raise StoppedError(_how_to_go_on(settings, out, _kept(out) if rows else done)) from None
    found = _judged(settings, scenario, out) if rows and settings.compare else None
    if json:
        told = [{name: row[name] for name in JSON} for row in rows]
        compared = {"compared": as_json(found)} if found else {}
        print_json({"policy": out, "scenario": scenario.name, "episodes": told} | compared)
    elif not rows:
        show(f"{settings.resume} has its {done} episodes already; for more, add --episodes N.")
    else:
        show(*(verdict(found, out) if found else [UNKNOWN]))
        show(f"Policy: {out}. Judge it: dmil evaluate --policy {out}")


class _Keeper(EpisodeRecorder):
    """Saves the policy after every episode, and tells what that came to."""

    def __init__(
        self, settings: TrainParameters, scenario: Scenario, out: Path, tell: Callable[[str], None]
    ) -> None:
        super().__init__(first=1)
        self._settings, self._scenario, self._out, self._tell = settings, scenario, out, tell

    def episode_ended(self, episode: int, result: Run) -> None:
        super().episode_ended(episode, result)
        settings, controller = self._settings, self._controller
        assert isinstance(controller, MemoryController)
        policy = policy_of(
            controller,
            self._scenario.network,
            name=settings.controller.name,
            options=settings.controller.complete().options,
            reward=settings.reward,
            reward_constants=settings.reward_constants,
            training=_record(settings, self._scenario, episode + 1),
        )
        save_policy(policy, self._out)
        _tell_row(self.rows[-1], self._tell, first=len(self.rows) == 1)


def _judged(settings: TrainParameters, scenario: Scenario, out: Path) -> Comparison | None:
    """Compare the policy where that is quick and runs no third-party code."""
    if settings.simulator != "queue" or ":" in settings.controller.name:
        return None
    whole = f"the policy is complete; evaluate it: dmil evaluate --policy {out}"
    with stopping(whole), waiting("comparing with controllers that need no training"):
        return judged(out, load_policy(out), recipe_of(settings), scenario)


def _resumed(settings: TrainParameters, policy: Policy, where: str) -> TrainParameters:
    """Take everything but length and file from the policy, and refuse what contradicts it."""
    record = policy.training
    if not {"recipe", "seed", "prior", "episodes"} <= record.keys():
        raise InputError(
            "it does not record how it was trained", where=where, expected="a policy of dmil train"
        )
    own: dict[str, Any] = {
        **record["recipe"],
        "controller": {"name": policy.controller, **policy.options},
        "reward": policy.reward,
        "reward_constants": policy.reward_constants,
        "seed": record["seed"],
        "prior": record["prior"],
    }
    trained = TrainParameters(**own)
    new = ("episodes", "out", "log", "resume", "compare")
    for name in settings.model_fields_set - set(new):
        given, found = getattr(settings, name), getattr(trained, name)
        if name == "controller":
            given = given.complete()
        if given != found:
            raise InputError(
                f"{name} differs from that of the policy",
                where=f"--resume {where}",
                expected="the same, or none: only --episodes, --out and --log can be new",
            )
    return trained.model_copy(update={name: getattr(settings, name) for name in new})


def _as_tuned(settings: TrainParameters, path: Path) -> TrainParameters:
    """Take the controller and its options from a tuning; given ones override them."""
    tuned = load_tuned(path)
    given = settings.controller if "controller" in settings.model_fields_set else None
    if given is not None and given.name != tuned.controller:
        raise InputError(
            f"options of '{tuned.controller}', not of '{given.name}'",
            where=f"--tuned {path}",
            mend=f"give --controller {tuned.controller}, or neither --controller nor --set",
        )
    options = tuned.chosen | (given.options if given else {})
    controller = ControllerChoice(**{"name": tuned.controller, **options})
    changes: dict[str, Any] = {"controller": controller}
    if "reward" not in settings.model_fields_set:
        changes["reward"] = tuned.reward
        if "reward_constants" not in settings.model_fields_set:
            changes["reward_constants"] = tuned.reward_constants
    return settings.model_copy(update=changes)


def _checked(settings: TrainParameters, options: dict[str, Any]) -> MemoryController:
    controller = make_controller(settings.controller.name, options)
    if not isinstance(controller, MemoryController):
        raise InputError(
            "it does not learn, so there is nothing to train",
            where=f"controller '{settings.controller.name}'",
            expected="one that learns, such as "
            + " or ".join(name for name, entry in CONTROLLERS.items() if entry.learns),
        )
    return controller


def _record(settings: TrainParameters, scenario: Scenario, episodes: int) -> dict[str, Any]:
    """Return what a policy says about its training."""
    return {
        "scenario": scenario.name,
        "recipe": recipe_of(settings).model_dump(mode="json", exclude_none=True),
        "seed": settings.seed,
        "prior": settings.prior,
        "episodes": episodes,
    }


COLUMNS: tuple[tuple[str, str, int], ...] = (
    ("episode", "episode", 0),
    ("travel_time_s", "travel time s", 1),
    ("wait_per_spawned_s", "W s", 2),
    ("w_over_vc", "W/V_c s/veh", 4),
    ("arrived_veh", "arrived veh", 0),
    ("entries_per_agent", "entries/int.", 1),
)
JSON = (*(name for name, _, _ in COLUMNS), "bytes_total")


def _tell_row(row: dict[str, Any], tell: Callable[[str], None], *, first: bool) -> None:
    """Print a line after each episode; a table would wait for the last one."""
    if first:
        tell("  ".join(title for _, title, _ in COLUMNS))
    cells = (f"{number(row[name], digits):>{len(title)}}" for name, title, digits in COLUMNS)
    tell("  ".join(cells))


def _kept(out: Path) -> int:
    """Ask the file: Ctrl-C may come before or after an episode's policy has reached it."""
    return int(load_policy(out).training["episodes"]) if out.exists() else 0


def _how_to_go_on(settings: TrainParameters, out: Path, done: int) -> str:
    if not done:
        return "no episode was finished, nothing was saved"
    return (
        f"{done} of {settings.episodes} episodes are kept; go on with: "
        f"dmil train --resume {out} --episodes {settings.episodes}"
    )
