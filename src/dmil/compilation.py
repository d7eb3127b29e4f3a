"""Compile kernels once per version of the source and keep them.

Numba's own cache looks at the file a function stands in, not at the files of the functions that it
calls: after an edit it can run yesterday's machine code. Here the name of the cache folder holds a
digest of every file with kernels, or with the tuples of arrays and the constants that they use. So
a changed kernel can never meet an old cache, and an installation in a read-only folder has a cache
too.
"""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numba

WARM_FILE = "warm"
MARKS = (b"kernel\n", b"(NamedTuple)")
"""What a file has that compiled code depends on: a kernel, or a tuple of arrays."""

Function = TypeVar("Function", bound=Callable[..., Any])


@cache
def cache_folder() -> Path:
    """Return the folder of compiled kernels for this version of the source (ours).

    ``DMIL_CACHE`` overrides the base folder, else it is the user's cache folder.
    """
    compiler = f"{numba.__version__} {sys.implementation.cache_tag}"
    digest = hashlib.blake2b(compiler.encode(), digest_size=8)
    package = Path(__file__).parent
    for path in sorted(package.rglob("*.py")):
        text = path.read_bytes()
        if any(mark in text for mark in MARKS):
            digest.update(path.relative_to(package).as_posix().encode())
            digest.update(text)
    return user_cache_folder() / "kernels" / digest.hexdigest()


def user_cache_folder() -> Path:
    """Return the folder for what can be made again but takes time (ours)."""
    base = os.environ.get("DMIL_CACHE") or os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    return Path(base).expanduser() / "dmil"


def is_cold() -> bool:
    """Tell whether kernels still have to be compiled for this version of the source (ours)."""
    return not (cache_folder() / WARM_FILE).exists()


def mark_warm() -> None:
    """Note that all kernels have been compiled (ours)."""
    # Where no cache can be written every start compiles, and nothing else is wrong.
    with suppress(OSError):
        (cache_folder() / WARM_FILE).touch()


def kernel(function: Function) -> Function:
    """Compile a function that allocates nothing; keep the machine code on disk (ours).

    Such a kernel changes arrays in place and returns numbers at most. It is compiled without
    Numba's reference counting of arrays, which otherwise takes most of the time of a function
    that works on tuples of arrays (five times the time of the queue simulator).
    """
    return _compiled(function, _nrt=False)


def allocating_kernel(function: Function) -> Function:
    """Compile a function that makes arrays; keep the machine code on disk (ours)."""
    return _compiled(function)


def _compiled(function: Function, **options: bool) -> Function:
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(cache_folder())
    try:
        compiled: Function = numba.njit(cache=True, error_model="numpy", **options)(function)
    finally:
        numba.config.CACHE_DIR = before
    return compiled
