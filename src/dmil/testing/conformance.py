"""What all checks share: the error, copies of what was handed out, numbers in words."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, fields, is_dataclass
from enum import StrEnum
from typing import NoReturn

import numpy as np

from dmil.seeding import global_random_state


class ConformanceError(AssertionError):
    """A controller, simulator or reward breaks a rule that every one of them keeps.

    Parameters
    ----------
    subject
        What was checked.
    rule
        The rule, one of `ControllerRule`, `SimulatorRule` or `RewardRule`.
    where
        Place: decision, run and network.
    found, expected
        What it did and what it should have done.
    """

    def __init__(self, subject: str, rule: StrEnum, where: str, found: str, expected: str) -> None:
        super().__init__(subject, rule, where, found, expected)
        self.subject = subject
        self.rule = rule
        self.where = where
        self.found = found
        self.expected = expected

    def __str__(self) -> str:
        return (
            f"{self.subject} breaks the rule {self.rule.name}: {self.rule.value}\n"
            f"  where:    {self.where}\n"
            f"  found:    {self.found}\n"
            f"  expected: {self.expected}"
        )


@dataclass
class Witness:
    """Says what is checked and where, so that a rule is checked in one line.

    The place is kept up to date by whoever checks.
    """

    subject: str
    where: str = "before the first run"

    def fail(self, rule: StrEnum, found: str, expected: str) -> NoReturn:
        """Raise a `ConformanceError`."""
        raise ConformanceError(self.subject, rule, self.where, found, expected)

    def expect(self, holds: bool | np.bool_, rule: StrEnum, found: str, expected: str) -> None:
        """Raise a `ConformanceError` unless something holds."""
        if not holds:
            self.fail(rule, found, expected)

    def expect_same(
        self,
        rule: StrEnum,
        before: object,
        after: object,
        name: str,
        found: str = "asked twice, {}",
        expected: str = "equal answers",
    ) -> None:
        """Raise a `ConformanceError` if two values differ; ``{}`` is where, see `difference`."""
        change = difference(before, after, name)
        self.expect(change is None, rule, found.format(change), expected)

    @contextmanager
    def no_exception(self, rule: StrEnum, call: str) -> Iterator[None]:
        """Turn any exception of the part that is checked into a broken rule."""
        try:
            yield
        except ConformanceError:
            raise
        except Exception as error:
            found = f"{call} raised {type(error).__name__}: {error}"
            raise ConformanceError(self.subject, rule, self.where, found, "no exception") from error

    @contextmanager
    def no_change(self, rule: StrEnum, **given: object) -> Iterator[None]:
        """Check that what was given is as it was."""
        before = copy.deepcopy(given)
        yield
        for name, value in given.items():
            self.expect_same(
                rule, before[name], value, name, "it changed {}", f"{name} is only read"
            )

    @contextmanager
    def no_global_chance(self, rule: StrEnum) -> Iterator[None]:
        """Check that the random numbers that all programs share are left alone."""
        before = global_random_state()
        yield
        self.expect(
            global_random_state() == before,
            rule,
            "it used the global random numbers of numpy or Python",
            "no random numbers but those of a generator that it was given",
        )


def difference(before: object, after: object, name: str) -> str | None:
    """Say where two values differ in type, shape or number; None if nowhere.

    They are numbers, arrays, or mappings, sequences and data classes of them, under a name.
    """
    if type(before) is not type(after):
        return f"{name}: {type(before).__name__} became {type(after).__name__}"
    if isinstance(before, np.ndarray) and isinstance(after, np.ndarray):
        return _array_difference(before, after, name)
    parts, others = _parts(before), _parts(after)
    if parts is None or others is None:
        same = before == after or (before != before and after != after)  # NaN stays NaN
        return None if same else f"{name}: {before!r} became {after!r}"
    if parts.keys() != others.keys():
        return f"{name}: {len(parts)} parts became {len(others)} or got other names"
    differences = (difference(parts[part], others[part], f"{name}{part}") for part in parts)
    return next((found for found in differences if found), None)


def _parts(value: object) -> Mapping[str, object] | None:
    if is_dataclass(value):
        return {f".{field.name}": getattr(value, field.name) for field in fields(value)}
    if isinstance(value, Mapping):
        return {f"[{key!r}]": part for key, part in value.items()}
    if isinstance(value, list | tuple):
        return {f"[{index}]": part for index, part in enumerate(value)}
    return None


def _array_difference(before: np.ndarray, after: np.ndarray, name: str) -> str | None:
    if before.shape != after.shape or before.dtype != after.dtype:
        return f"{name}: {array_in_words(before)} became {array_in_words(after)}"
    if before.tobytes() == after.tobytes():
        return None
    changed = np.argwhere(np.atleast_1d(before != after))
    if not changed.size:
        return None
    place = tuple(changed[0].tolist())
    values = np.atleast_1d(before)[place], np.atleast_1d(after)[place]
    return f"{name}[{', '.join(map(str, place))}]: {values[0]} became {values[1]}"


def array_in_words(value: object) -> str:
    """Describe something that should be an array."""
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape} and type {value.dtype}"
    return f"a {type(value).__name__}"
