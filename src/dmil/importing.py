"""Parts that a user brings: found by import path, never by registration, never because a file says.

Importing runs code. A program's own code may name what it likes. A file (a policy, a tuned
controller, a configuration) may name a part by its import path only where the user has named the
same path, too: `trust` does so for a program, on the command line every option does.
"""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any

from dmil.errors import InputError

Trust = tuple[frozenset[str], bool]
"""The import paths that the user has named, and whether nothing else may be imported at all."""
_trust: Trust = (frozenset(), False)


def trust(*paths: str) -> None:
    """Let files name these parts, too: they are imported, and what they do is done.

    Parameters
    ----------
    paths
        Import paths such as ``my_module:MyController``.
    """
    set_trust((_trust[0] | frozenset(paths), _trust[1]))


def get_trust() -> Trust:
    """Return what is trusted, for a process that works for this one."""
    return _trust


def set_trust(found: Trust) -> None:
    """Trust what another process trusts, and nothing else."""
    global _trust
    _trust = found


@contextmanager
def only(paths: Iterable[str]) -> Iterator[None]:
    """Import nothing but these parts, whoever asks for others, until the block ends.

    Parameters
    ----------
    paths
        Import paths.
    """
    before = _trust
    set_trust((frozenset(paths), True))
    try:
        yield
    finally:
        set_trust(before)


def check_trusted(name: object, kind: str, *, where: str) -> None:
    """Check that a part that a file names is one of ours, or named by the user, too.

    Nothing is imported.

    Parameters
    ----------
    name
        A name of ours, or an import path.
    kind
        What it is meant to be.
    where
        The file.

    Raises
    ------
    InputError
        If it is an import path that the user has not named.
    """
    if isinstance(name, str) and ":" in name and name not in _trust[0]:
        raise _untrusted(f"it names the {kind} '{name}', which is code and none of dmil's", where)


def import_object(path: str, kind: str) -> Any:
    """Import what ``package.module:name`` names.

    Parameters
    ----------
    path
        Import path; the module may be in the current folder.
    kind
        What it is meant to be, for the error.

    Raises
    ------
    InputError
        If there is no such module or no such name in it, or on the command line, if the user has
        not typed it.
    """
    named, alone = _trust
    where = f"{kind} '{path}'"
    if alone and path not in named:
        raise _untrusted("it is code and none of dmil's, and only a file names it", where)
    module, _, name = path.partition(":")
    # The path of an installed command begins with that command's folder, not with the user's.
    if os.getcwd() not in sys.path:
        sys.path.append(os.getcwd())
    try:
        found = importlib.import_module(module)
    except (Exception, SystemExit) as error:  # a user's module may fail in any way
        problem = f"module '{module}' cannot be imported ({type(error).__name__}: {error})"
    else:
        if hasattr(found, name):
            return getattr(found, name)
        file = getattr(found, "__file__", None)
        problem = f"module '{module}' has no '{name}'" + (f" ({file})" if file else "")
    raise InputError(
        problem,
        where=where,
        expected="package.module:Name of something that can be imported",
        mend="start from the folder that holds the module, or put it on PYTHONPATH",
    )


def _untrusted(problem: str, where: str) -> InputError:
    return InputError(
        problem,
        where=where,
        expected="a name of dmil, or an import path that is also on the command line",
        mend="if you know that code and want it to run, add --trust with this path",
    )
