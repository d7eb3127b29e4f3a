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
from typing import Any, SupportsIndex, TypeVar, cast

import numba
from numba import types

WARM_FILE = "warm"
MARKS = (b"kernel\n", b"(NamedTuple)")
"""What a file has that compiled code depends on: a kernel, or a tuple of arrays."""

Function = TypeVar("Function", bound=Callable[..., Any])


@cache
def cache_folder() -> Path:
    """Return the folder of compiled kernels for this version of the source.

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
    """Return the folder for what can be made again but takes time."""
    base = os.environ.get("DMIL_CACHE") or os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    return Path(base).expanduser() / "dmil"


def is_cold() -> bool:
    """Tell whether kernels still have to be compiled for this version of the source."""
    return not (cache_folder() / WARM_FILE).exists()


def mark_warm() -> None:
    """Note that all kernels have been compiled."""
    # Where no cache can be written every start compiles, and nothing else is wrong.
    with suppress(OSError):
        (cache_folder() / WARM_FILE).touch()


class Kernel:
    """A compiled function.

    It is compiled anew for every caller's types. Called from Python it needs a wrapper that takes
    arrays out of objects, which for tuples of arrays costs more than the function itself to
    compile: another kernel gets it without one, and for whole numbers of one width, whatever width
    it has at hand. Together that is half of what a first start takes.

    Parameters
    ----------
    function
        What to compile.
    options
        Of Numba.
    """

    def __init__(self, function: Callable[..., Any], **options: bool) -> None:
        self.__wrapped__ = function
        self.__doc__ = function.__doc__
        self.__module__, self.__qualname__ = function.__module__, function.__qualname__
        self._from_python = _compiled(function, cache=True, no_cfunc_wrapper=True, **options)
        self._from_kernels = _compiled(
            function, no_cpython_wrapper=True, no_cfunc_wrapper=True, **options
        )
        for_types = self._from_kernels.get_call_template
        self._from_kernels.get_call_template = lambda arguments, named: for_types(
            tuple(map(_of_one_width, arguments)), named
        )

    def __call__(self, *arguments: Any) -> Any:
        """Run it, compiled for these arguments."""
        return self._from_python(*arguments)

    def __reduce_ex__(self, protocol: SupportsIndex) -> str | tuple[Any, ...]:
        """Copy and pickle it as functions are, by name; one that stands in another, as it is."""
        if "<locals>" in self.__qualname__:
            return super().__reduce_ex__(protocol)
        return self.__qualname__

    def compiled_for(self, arguments: tuple[Any, ...]) -> Callable[..., Any]:
        """Return what Python calls for arguments of these types and no others."""
        kinds = tuple(self._from_python.typeof_pyval(each) for each in arguments)
        entry: Callable[..., Any] = self._from_python.compile(kinds)
        return entry

    @property
    def _numba_type_(self) -> types.Dispatcher:
        """What other kernels see."""
        return types.Dispatcher(self._from_kernels)


def kernel(function: Function) -> Function:
    """Compile a function that allocates nothing; keep the machine code on disk.

    Such a kernel changes arrays in place and returns numbers at most. It is compiled without
    Numba's reference counting of arrays, which otherwise takes most of the time of a function
    that works on tuples of arrays (five times the time of the queue simulator).
    """
    return cast(Function, Kernel(function, _nrt=False))


def inlined_kernel(function: Function) -> Function:
    """Compile a small function into every kernel that calls it.

    A call hands over all arrays of all tuples, which may take longer than what it is for.
    """
    return cast(Function, Kernel(function, _nrt=False, forceinline=True))


def allocating_kernel(function: Function) -> Function:
    """Compile a function that makes arrays; keep the machine code on disk."""
    return cast(Function, Kernel(function))


class TypedOnce:
    """A kernel that Python calls with arguments of the same types every time.

    A call of the kernel itself asks every array of every argument for its type first. For 50 arrays
    in tuples that takes longer than to decide for 25 intersections. Here the first call asks, and
    nobody again: the caller has to see to it that types, numbers of dimensions and contiguity stay
    as they are.

    Parameters
    ----------
    function
        A kernel.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        assert isinstance(function, Kernel), "a function that is compiled"
        self._kernel = function
        self._entry: Callable[..., Any] | None = None

    def __call__(self, *arguments: Any) -> Any:
        """Run it."""
        entry = self._entry
        if entry is None:
            entry = self._entry = self._kernel.compiled_for(arguments)
        return entry(*arguments)

    def __reduce__(self) -> tuple[Any, ...]:
        """Leave the machine code to this process."""
        return TypedOnce, (self._kernel,)


def _compiled(function: Callable[..., Any], **options: bool) -> Any:
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(cache_folder())
    try:
        return numba.njit(error_model="numpy", **options)(function)
    finally:
        numba.config.CACHE_DIR = before


def _of_one_width(type_: types.Type) -> types.Type:
    plain = types.unliteral(type_)
    return types.int64 if isinstance(plain, types.Integer) and plain.signed else plain
