"""Parts that a user brings: found by import path, never by registration."""

from __future__ import annotations

import importlib
import os
import sys
from typing import Any

from dmil.errors import InputError


def import_object(path: str, kind: str) -> Any:
    """Import what ``package.module:name`` names (ours).

    Parameters
    ----------
    path
        Import path; the module may be in the current folder.
    kind
        What it is meant to be, for the error.

    Raises
    ------
    InputError
        If there is no such module or no such name in it.
    """
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
        where=f"{kind} '{path}'",
        expected="package.module:Name of something that can be imported",
        mend="start from the folder that holds the module, or put it on PYTHONPATH",
    )
