"""Every error a user can meet, in one tree.

A message names the place, what was found, what was expected and how to mend it.
The command line prints the message and exits with code 2; it never shows a traceback for these.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class DmilError(Exception):
    """Base of all errors that are the user's to mend."""


class InputError(DmilError):
    """A value, file or folder given by the user cannot be used.

    Parameters
    ----------
    problem
        What was found.
    where
        File and place inside it, or the name of the option.
    expected
        What would have been right.
    mend
        What to do about it.
    """

    def __init__(
        self,
        problem: str,
        *,
        where: str | None = None,
        expected: str | None = None,
        mend: str | None = None,
    ) -> None:
        self.problem = problem
        self.where = where
        self.expected = expected
        self.mend = mend
        parts = [f"{where}: {problem}" if where else problem]
        if expected:
            parts.append(f"expected {expected}")
        message = "; ".join(parts)
        if mend:
            message = f"{message}. {mend[0].upper()}{mend[1:]}"
        super().__init__(message if message.endswith((".", "?", "!")) else f"{message}.")

    def __reduce__(self) -> tuple[object, ...]:
        # Keyword arguments do not survive the default pickling between worker processes.
        return _rebuild, (type(self), self.problem, self.where, self.expected, self.mend)


class NetworkError(InputError):
    """A road network is inconsistent."""


class DemandError(InputError):
    """Demand (rates, trips, routes) is inconsistent."""


class UnknownNameError(InputError):
    """A name that is in no registry."""


class OutputError(InputError):
    """An output file or folder cannot be used."""


class PolicyError(InputError):
    """A saved policy cannot be used here."""


class SimulationError(InputError):
    """A simulation could not begin or ended before its time; with the simulator's own message."""


class MissingExtraError(DmilError):
    """An optional dependency is not installed."""

    def __init__(self, extra: str) -> None:
        self.extra = extra
        super().__init__(
            f"this needs the optional extra '{extra}'. Install it with: pip install 'dmil[{extra}]'"
        )

    def __reduce__(self) -> tuple[object, ...]:
        return type(self), (self.extra,)


class DivergedError(DmilError):
    """What a controller learned is no longer a number.

    Parameters
    ----------
    controller
        Name of the controller.
    what
        Which of its numbers, such as "values of the phases".
    at_time_s
        Time since the run began.
    """

    def __init__(self, controller: str, what: str, at_time_s: int) -> None:
        self.controller = controller
        self.what = what
        self.at_time_s = at_time_s
        super().__init__(
            f"controller '{controller}' diverged at {at_time_s} s: {what} that are not finite. "
            "Smaller rewards or a smaller learning rate may help."
        )

    def __reduce__(self) -> tuple[object, ...]:
        return type(self), (self.controller, self.what, self.at_time_s)


def _rebuild(
    kind: type[InputError],
    problem: str,
    where: str | None,
    expected: str | None,
    mend: str | None,
) -> InputError:
    return kind(problem, where=where, expected=expected, mend=mend)


def unknown_name(
    kind: str, name: str, known: Iterable[str], *, where: str | None = None
) -> UnknownNameError:
    """Build the error for a name that does not exist, suggesting the nearest.

    Parameters
    ----------
    kind
        What the name should have been, such as "controller".
    name
        The name that was given.
    known
        All names that exist.
    where
        File or option the name came from.
    """
    names = sorted(known)
    near = difflib.get_close_matches(name.lower(), names, n=1, cutoff=0.4)
    return UnknownNameError(
        f"there is no {kind} named '{name}'",
        where=where,
        expected=f"one of {', '.join(names)}",
        mend=f"did you mean '{near[0]}'?" if near else None,
    )
