"""Where runs happen: processes of this machine, or Ray. The same items give the same results."""

from __future__ import annotations

import multiprocessing
import os
import signal
import socket
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import Protocol, TypeVar

from dmil.errors import DmilError, InputError, MissingExtraError, unknown_name
from dmil.importing import Trust, get_trust, set_trust
from dmil.parallel.worker_server import start_worker_server

Item = TypeVar("Item")
Result = TypeVar("Result")


class Executor(Protocol):
    """Applies a function to many items, in any order."""

    def map(self, function: Callable[[Item], Result], items: Sequence[Item]) -> Iterator[Result]:
        """Yield results as they come; closing the iterator drops what has not come."""


class LocalExecutor:
    """Processes of this machine; as a context manager it keeps them from one map to the next.

    Parameters
    ----------
    jobs
        How many; 1 runs everything in this process. None: one per core that is ours.
    """

    def __init__(self, jobs: int | None = None) -> None:
        if jobs is not None and jobs < 1:
            raise InputError(f"{jobs} jobs", where="jobs", expected="at least 1")
        self.jobs = jobs or available_cores()
        self._keeps = False
        self._kept: ProcessPoolExecutor | None = None

    def __enter__(self) -> LocalExecutor:
        self._keeps = True
        return self

    def __exit__(self, *exception: object) -> None:
        self._keeps = False
        if self._kept is not None:
            self._kept.shutdown(wait=True)
            self._kept = None

    def map(self, function: Callable[[Item], Result], items: Sequence[Item]) -> Iterator[Result]:
        """Yield results as they come."""
        if self.jobs == 1 or len(items) < 2:
            yield from map(function, items)
            return
        pool = self._kept or self._started(function, len(items))
        self._kept = pool if self._keeps else None
        finished = False
        try:
            with _put_off(signal.SIGINT, signal.SIGTERM):  # half begun it cannot be shut down
                futures = [pool.submit(function, item) for item in items]
            for future in as_completed(futures):
                yield future.result()
            finished = True
        except BrokenProcessPool:
            raise DmilError(
                "a worker process was killed, perhaps for want of memory, or a script calls this"
                " without \"if __name__ == '__main__':\" around it; finished runs are kept:"
                " repeat the command to continue; --jobs 1 needs least memory"
            ) from None
        finally:
            with _put_off(signal.SIGINT, signal.SIGTERM):  # a second Ctrl-C would leave it hanging
                if not finished:  # do not wait for started work
                    _terminate(pool)
                    self._kept = None
                if pool is not self._kept:
                    pool.shutdown(wait=True, cancel_futures=True)

    def _started(self, function: Callable[[Item], Result], items: int) -> ProcessPoolExecutor:
        # A server that imports once and forks workers: quick, and free of this process's threads.
        context = multiprocessing.get_context("forkserver")
        start_worker_server(function_module(function))
        workers = self.jobs if self._keeps else min(self.jobs, items)
        return ProcessPoolExecutor(
            workers, mp_context=context, initializer=_prepare_worker, initargs=(get_trust(),)
        )


class RayExecutor:
    """Tasks on Ray.

    Parameters
    ----------
    address
        A cluster's address; None starts Ray on this machine and stops it afterwards.
    jobs
        Cores for a Ray started here.
    """

    def __init__(self, address: str | None = None, jobs: int | None = None) -> None:
        self._address, self._jobs = address, jobs
        if address:
            _check_reachable(address)

    def map(self, function: Callable[[Item], Result], items: Sequence[Item]) -> Iterator[Result]:
        """Yield results as they come."""
        try:
            import ray
        except ImportError:
            raise MissingExtraError("ray") from None
        try:
            ray.init(
                address=self._address or "local",
                num_cpus=None if self._address else self._jobs or available_cores(),
                include_dashboard=False if not self._address else None,
                log_to_driver=False,
                logging_level="error",
            )
        except (ConnectionError, ValueError, RuntimeError) as error:
            raise _no_cluster(self._address, error) from None
        try:
            shared, trusted = ray.put(function), get_trust()
            task = ray.remote(_apply)
            waiting = [task.remote(shared, item, trusted) for item in items]
            while waiting:
                done, waiting = ray.wait(waiting)
                yield from ray.get(done)
        finally:
            ray.shutdown()


EXECUTORS = {"local": "processes of this machine", "ray": "tasks on Ray (extra 'ray')"}
"""The named executors, each with one line for people."""


def make_executor(name: str, *, jobs: int | None = None, address: str | None = None) -> Executor:
    """Make an executor from its name.

    Parameters
    ----------
    name
        A name of `EXECUTORS`.
    jobs
        Parallel processes; by default one per core.
    address
        Address of a Ray cluster.

    Raises
    ------
    InputError
        If there is no such executor, or an option does not fit it.
    """
    if name not in EXECUTORS:
        raise unknown_name("executor", name, EXECUTORS)
    if name == "ray":
        return RayExecutor(address, jobs)
    if address is not None:
        raise InputError("an address without Ray", where="ray address", mend="add: --executor ray")
    return LocalExecutor(jobs)


def available_cores() -> int:
    """Return the cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def function_module(function: Callable[..., object]) -> str:
    """Return the module of a function or of the function inside a partial."""
    inner = getattr(function, "func", function)
    return str(inner.__module__)


def _check_reachable(address: str) -> None:
    """Knock before Ray does: Ray itself tries for minutes."""
    host, _, port = address.removeprefix("ray://").rpartition(":")
    if not host or not port.isdigit():
        return
    try:
        socket.create_connection((host, int(port)), timeout=10).close()
    except (OSError, OverflowError) as error:
        raise _no_cluster(address, error) from None


def _no_cluster(address: str | None, error: Exception) -> InputError:
    return InputError(
        f"no Ray cluster answers ({error})",
        where=f"ray address '{address}'",
        expected="the address of a running cluster, or none to start Ray here",
    )


def _apply(function: Callable[[Item], Result], item: Item, trusted: Trust) -> Result:
    set_trust(trusted)
    return function(item)


@contextmanager
def _put_off(*numbers: signal.Signals) -> Iterator[None]:
    """Let signals wait until the block has ended, whichever thread they reach."""
    if threading.current_thread() is not threading.main_thread():  # nor are they handled here
        yield
        return
    came: list[int] = []
    before = {each: signal.signal(each, lambda number, _: came.append(number)) for each in numbers}
    try:
        yield
    finally:
        for each, handler in before.items():
            signal.signal(each, handler or signal.SIG_DFL)
        if came:
            signal.raise_signal(came[0])


def _terminate(pool: ProcessPoolExecutor) -> None:
    # The pool has a method of its own for this from Python 3.14 on.
    for worker in list((pool._processes or {}).values()):
        worker.terminate()


def _prepare_worker(trusted: Trust) -> None:
    set_trust(trusted)
    # Ctrl-C reaches every process of the terminal; only the first one shall act on it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    # A parent that was killed cannot tell its workers; they would wait for work for ever.
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
