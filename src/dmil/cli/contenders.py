"""Who runs in a comparison: controllers, policies, tuned controllers, baselines, the reference."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dmil.cli.choices import accepted
from dmil.cli.terminal import say
from dmil.controllers import CONTROLLERS, check_controller
from dmil.controllers.variants import parse_variant
from dmil.errors import InputError
from dmil.studies.comparison import REFERENCE, Contender
from dmil.studies.tuning import load_tuned
from dmil.training import Policy

if TYPE_CHECKING:
    from dmil.cli.evaluate import EvaluateParameters

BASELINES = ("fixed-cycle", "longest-queue-first", "max-pressure")


def contenders_of(settings: EvaluateParameters, policies: list[Policy]) -> list[Contender]:
    """Return everyone who runs; those to judge first, each with a label of its own (ours).

    Parameters
    ----------
    settings
        The command's.
    policies
        The policies it names, read.

    Raises
    ------
    InputError
        There is no such controller, or a tuned file or the reference cannot be used.
    """
    made: dict[str, Contender] = {}

    def add(label: str, **contender: Any) -> None:
        unique, count = label, 2
        while unique in made:
            unique, count = f"{label} ({count})", count + 1
        made[unique] = Contender(unique, **contender)

    settings.make_reward()
    own = {"reward": settings.reward, "reward_constants": settings.reward_constants}
    mode = _mode(settings)
    for path, policy in zip(settings.policy, policies, strict=True):
        options = accepted(policy.controller, mode) | settings.changes
        learned = {"reward": policy.reward, "reward_constants": policy.reward_constants}
        add(path.name, options=json.dumps(options), policy=str(path), **learned)
    for choice in settings.controller:
        check_controller(choice.name)
        # What freezes a learner goes over its defaults, not over what somebody asked for.
        frozen = choice.options | _untrained(choice.name, mode)
        options = frozen | choice.changed | settings.changes
        add(choice.label, **_named(choice.name, options), **own)
        _warn_of_nothing_learned(choice.label, options)
    for path in settings.tuned:
        tuned = load_tuned(path)
        options = tuned.chosen | _untrained(tuned.controller, mode) | settings.changes
        its = {"reward": tuned.reward, "reward_constants": tuned.reward_constants}
        add(f"{tuned.label} tuned", **_named(tuned.controller, options), **its)
        _warn_of_nothing_learned(tuned.label, options, path)
    for name in BASELINES if settings.baselines else ():
        if name not in made:
            add(name, controller=name)
    if settings.reference not in made and settings.reference != REFERENCE:
        add(settings.reference, **_reference(settings.reference, list(made)))
    return list(made.values())


def _named(name: str, options: dict[str, Any]) -> dict[str, Any]:
    return {"controller": name, "options": json.dumps(options)}


def _warn_of_nothing_learned(
    label: str, options: dict[str, Any], tuned: Path | None = None
) -> None:
    if options.get("learning") is False:
        train = "train it" if tuned is None else f"train it (dmil train --tuned {tuned})"
        say(f"{label} has learned nothing yet and is frozen: {train}, or add --learn.")


def _reference(wanted: str, made: list[str]) -> dict[str, Any]:
    variant = parse_variant(wanted)
    entry = CONTROLLERS.get(variant.name)
    if entry is None or entry.learns:
        fixed = [name for name, entry in CONTROLLERS.items() if not entry.learns]
        raise InputError(
            f"found '{wanted}'",
            where="--reference",
            expected=f"one of {', '.join(dict.fromkeys([*made, *fixed]))}",
        )
    return {"controller": variant.name, "options": json.dumps(dict(variant.options))}


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
