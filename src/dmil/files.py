"""Files that appear whole under their name or not at all."""

from __future__ import annotations

import fcntl
import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from dmil.errors import OutputError


def write_atomically(path: Path, write: Callable[[Path], None]) -> None:
    """Let ``write`` fill a temporary file next to ``path``, then put it in place.

    Raises
    ------
    OutputError
        The folder or file cannot be written.
    """
    if path.exists() and not path.is_file():
        # In place of a device, such as /dev/null, a file would be put: for root, for everybody.
        raise OutputError(
            "it is a folder" if path.is_dir() else "it is no ordinary file",
            where=str(path),
            expected="the name of a file",
        )
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(
            prefix=f".{path.stem}-", suffix=path.suffix, dir=path.parent
        )
    except OSError as error:
        raise _not_writable(path, error) from error
    os.close(handle)
    temporary = Path(name)
    try:
        write(temporary)
        # mkstemp makes files for the owner only; results are to be shared like any other file.
        temporary.chmod(0o666 & ~_umask())
        temporary.replace(path)
    except OSError as error:
        raise _not_writable(path, error) from error
    finally:
        temporary.unlink(missing_ok=True)


def write_text_atomically(path: Path, text: str) -> None:
    """Write a text in UTF-8, whole or not at all.

    Raises
    ------
    OutputError
        The folder or file cannot be written.
    """

    def write(unfinished: Path) -> None:
        unfinished.write_text(text, encoding="utf-8")

    write_atomically(path, write)


@contextmanager
def held(lock: Path, *, where: Path, work: str) -> Iterator[None]:
    """Keep other processes out of a piece of work, by a file that is there as long as this one.

    The system releases it when this process ends, in whatever way.

    Parameters
    ----------
    lock
        The file.
    where, work
        What it stands for, for the error.

    Raises
    ------
    OutputError
        Another process has it, or the folder cannot be written.
    """
    try:
        lock.parent.mkdir(parents=True, exist_ok=True)
        file = lock.open("a", encoding="utf-8")
    except OSError as error:
        raise OutputError(
            f"cannot be made or written ({error.strerror})",
            where=str(lock.parent),
            mend="choose another --out",
        ) from None
    with file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            # Who held it until just now removed the file; another one may hold a new file already.
            alone = os.path.samestat(os.fstat(file.fileno()), lock.stat())
        except OSError:
            alone = False
        if not alone:
            raise OutputError(
                f"another process is at work on this {work}",
                where=str(where),
                mend="wait for its end, or choose another --out",
            )
        try:
            yield
        finally:
            lock.unlink(missing_ok=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _not_writable(path: Path, error: OSError) -> OutputError:
    return OutputError(
        f"cannot be written ({error.strerror or error})",
        where=str(path),
        mend="choose another output folder or free the space",
    )
