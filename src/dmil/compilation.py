"""Compile kernels once per version of the source and keep them.

Numba's own cache looks at the file a function stands in, not at the files of the functions that it
calls: after an edit it can run yesterday's machine code. Here the cache folder's name holds a digest
of every kernel file of the package, so a changed kernel can never meet an old cache, and an
installation in a read-only folder has a cache too.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numba

Function = TypeVar("Function", bound=Callable[..., Any])


@cache
def cache_folder() -> Path:
    """Return the folder of compiled kernels for this version of the source (ours).

    ``DMIL_CACHE`` overrides the base folder, else it is the user's cache folder.
    """
    digest = hashlib.blake2b(numba.__version__.encode(), digest_size=8)
    package = Path(__file__).parent
    for path in sorted(package.rglob("*.py")):
        text = path.read_bytes()
        if b"@kernel" in text:
            digest.update(path.relative_to(package).as_posix().encode())
            digest.update(text)
    base = os.environ.get("DMIL_CACHE") or os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    return Path(base).expanduser() / "dmil" / "kernels" / digest.hexdigest()


def kernel(function: Function) -> Function:
    """Compile a function on first call and keep the machine code on disk (ours).

    Kernels take and return arrays and numbers, hold no objects and draw no random numbers.
    """
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(cache_folder())
    try:
        compiled: Function = numba.njit(cache=True, error_model="numpy")(function)
    finally:
        numba.config.CACHE_DIR = before
    return compiled
