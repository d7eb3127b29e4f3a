"""Where work happens: processes of this machine, or Ray."""

from dmil.parallel.executors import EXECUTORS, Executor, LocalExecutor, RayExecutor, make_executor

__all__ = ["EXECUTORS", "Executor", "LocalExecutor", "RayExecutor", "make_executor"]
