"""Trained policies as files: flat arrays and a JSON header, no pickle."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from dmil.controllers import CONTROLLERS, MemoryController, RunContext, make_controller
from dmil.controllers.tabular.agents import agents_of
from dmil.errors import InputError, PolicyError
from dmil.files import write_atomically
from dmil.importing import check_trusted
from dmil.network import RoadNetwork
from dmil.rewards import PAPER_CONSTANTS, Reward, RewardConstants, make_reward
from dmil.scenarios import SignalTiming
from dmil.seeding import stream
from dmil.version import __version__

FORMAT = "dmil-policy"
FORMAT_VERSION = 1
HEADER = "header"
KEYED_BY = {"embedding", "scale_levels", "tolerance", "announced"}
"""Options that say under which key a state stands: what was learned is found by no other."""
RETIRED: dict[str, dict[str, float]] = {
    "factored": {"evidence": 0.0},
    "dual-memory": {"stage_untried": False},
}
"""Options that controllers had once, with the value that changed nothing: all default to it."""
HEADER_FIELDS = {
    "controller": str,
    "options": dict,
    "reward": str,
    "shapes": list,
    "training": dict,
}


@dataclass(frozen=True)
class Policy:
    """What was learned, and all that is needed to use it again.

    Attributes
    ----------
    controller: str
        Name of the controller.
    options: dict
        Its settings.
    reward: str
        The reward it learned from.
    shapes: list of str
        Signature of the shape of each agent's intersection, in the network's order.
    arrays: dict of arrays
        What the controller's ``restore`` takes.
    training: dict
        Where and how long it was trained: scenario, seed, episodes.
    reward_constants: RewardConstants
        Constants of that reward.
    """

    controller: str
    options: dict[str, Any]
    reward: str
    shapes: list[str]
    arrays: dict[str, np.ndarray] = field(repr=False)
    training: dict[str, Any]
    reward_constants: RewardConstants = PAPER_CONSTANTS

    def make_reward(self) -> Reward:
        """Make the reward it learned from (ours).

        Raises
        ------
        InputError
            If there is none of that name.
        """
        return make_reward(self.reward, self.reward_constants)


def policy_of(
    controller: MemoryController,
    network: RoadNetwork,
    *,
    name: str,
    options: dict[str, Any],
    reward: str,
    training: dict[str, Any],
    reward_constants: RewardConstants = PAPER_CONSTANTS,
) -> Policy:
    """Take a trained controller's policy (ours).

    Parameters
    ----------
    controller
        After at least one run.
    network
        Where it was trained.
    name, options, reward, training, reward_constants
        See `Policy`.
    """
    return Policy(
        controller=name,
        options=options,
        reward=reward,
        shapes=shapes_of(network),
        arrays={key: np.asarray(array) for key, array in controller.arrays().items()},
        training=training,
        reward_constants=reward_constants,
    )


def save_policy(policy: Policy, path: Path) -> None:
    """Write a policy; the same policy gives the same bytes (ours).

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    header = {
        "format": FORMAT,
        "version": FORMAT_VERSION,
        "dmil": __version__,
        "reward_constants": policy.reward_constants.changed,
        **{key: getattr(policy, key) for key in HEADER_FIELDS},
    }
    text = np.frombuffer(json.dumps(header, sort_keys=True).encode(), np.uint8)

    def write(unfinished: Path) -> None:
        with unfinished.open("wb") as file:
            np.savez_compressed(file, allow_pickle=False, **{HEADER: text}, **policy.arrays)

    write_atomically(path, write)


def load_policy(path: Path) -> Policy:
    """Read a policy. Reading runs no code of the file's.

    Raises
    ------
    PolicyError
        If the file is missing, damaged, no policy, of another version of the format, or trained
        with an option that is gone.
    InputError
        If it names a controller, reward or embedding by an import path that is not trusted, see
        `dmil.trust`.
    """
    where = str(path)
    try:
        with path.open("rb") as raw, np.load(raw, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        header = json.loads(arrays.pop(HEADER).tobytes())
    except FileNotFoundError:
        raise PolicyError(
            "there is no such file", where=where, mend="make one with: dmil train --out FILE"
        ) from None
    except Exception:  # what a damaged archive raises depends on where it is damaged
        raise PolicyError(
            "not a whole policy file", where=where, expected="a file that dmil train wrote"
        ) from None
    if not isinstance(header, dict) or header.get("format") != FORMAT:
        raise PolicyError("no policy", where=where, expected="a file that dmil train wrote")
    if header.get("version") != FORMAT_VERSION:
        raise PolicyError(
            f"version {header.get('version')} of the format, written by dmil {header.get('dmil')}",
            where=where,
            expected=f"version {FORMAT_VERSION}",
            mend="train it again with this version of dmil",
        )
    for key, kind in HEADER_FIELDS.items():
        if not isinstance(header.get(key), kind):
            raise _misfit(header, key, where)
    check_trusted(header["controller"], "controller", where=where)
    check_trusted(header["reward"], "reward", where=where)
    check_trusted(header["options"].get("embedding"), "embedding", where=where)
    try:
        constants = RewardConstants.model_validate(header.get("reward_constants", {}))
    except ValidationError:
        raise _misfit(header, "reward_constants", where) from None
    header["options"] = _without_retired(header["controller"], header["options"], where)
    known = {key: header[key] for key in HEADER_FIELDS}
    return Policy(**known, arrays=arrays, reward_constants=constants)


def _misfit(header: dict[str, Any], key: str, where: str) -> PolicyError:
    return PolicyError(
        f"its header has {header.get(key)!r} for '{key}'",
        where=where,
        expected="a file as dmil train wrote it",
    )


def _without_retired(controller: str, options: dict[str, Any], where: str) -> dict[str, Any]:
    """Leave out options that are gone; refuse what was learned with one that had an effect."""
    retired = RETIRED.get(controller, {})
    for name in retired.keys() & options.keys():
        if options[name] != retired[name]:
            raise PolicyError(
                f"it was trained with {name} = {options[name]!r}, an option that is gone",
                where=where,
                expected=f"{name} = {retired[name]!r}, as it was by default",
                mend="train it again with this version of dmil",
            )
    return {name: value for name, value in options.items() if name not in retired}


def controller_of(
    policy: Policy, network: RoadNetwork, *, where: str, **changes: object
) -> MemoryController:
    """Make the controller of a policy, ready for runs on a network.

    Parameters
    ----------
    policy
        What was learned.
    network
        Where it shall act; its intersections must have the shapes of the policy's, in order.
    where
        File of the policy, for errors.
    changes
        Options to change, such as ``learning=False``.

    Raises
    ------
    PolicyError
        If the network does not fit, or a change would read what was learned by other keys.
    """
    for name in KEYED_BY & changes.keys():
        trained = policy.options.get(name, _usual(policy.controller, name))
        if changes[name] != trained:
            raise PolicyError(
                f"{name} = {changes[name]} for a policy that was trained with {trained}",
                where=where,
                mend="leave it out, or train another policy: entries are found by it",
            )
    shapes = shapes_of(network)
    if len(shapes) != len(policy.shapes):
        raise PolicyError(
            f"a policy for {len(policy.shapes)} intersections",
            where=where,
            expected=f"one for the {len(shapes)} of '{network.name}'",
            mend=f"it was trained on '{policy.training.get('scenario')}': use it there",
        )
    for i, (found, expected) in enumerate(zip(policy.shapes, shapes, strict=True)):
        if found != expected:
            raise PolicyError(
                f"a policy for another shape at intersection '{network.intersections[i].id}'",
                where=where,
                expected="the same approaches, turns and phases as in training",
                mend=f"it was trained on '{policy.training.get('scenario')}': use it there",
            )
    controller = make_controller(policy.controller, {**policy.options, **changes})
    if not isinstance(controller, MemoryController):
        raise InputError(f"controller '{policy.controller}' has no memory to restore", where=where)
    # A run's own begin follows; this one only tells the controller what it controls.
    controller.reset(RunContext(network, SignalTiming(), stream(0, "restore")))
    controller.restore(policy.arrays)
    return controller


def _usual(controller: str, name: str) -> object:
    """Return the default of a controller's option."""
    entry = CONTROLLERS.get(controller)
    fields = entry.settings.model_fields if entry and entry.settings else {}
    return fields[name].default if name in fields else None


def shapes_of(network: RoadNetwork) -> list[str]:
    """Return the signature of every intersection's shape, in the network's order (ours)."""
    agents = agents_of(network)
    return [agents.signatures[shape] for shape in agents.shape]
