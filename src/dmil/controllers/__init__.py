"""Controllers: the protocol, the table of names, one file per controller."""

from dmil.controllers.catalogue import CONTROLLERS, RECOMMENDED
from dmil.controllers.protocol import (
    NO_MEMORY,
    Controller,
    MemoryController,
    MemoryUse,
    RunContext,
)
from dmil.controllers.registry import check_controller, make_controller, make_settings
from dmil.controllers.tabular.agents import Prior

__all__ = [
    "CONTROLLERS",
    "NO_MEMORY",
    "RECOMMENDED",
    "Controller",
    "MemoryController",
    "MemoryUse",
    "Prior",
    "RunContext",
    "check_controller",
    "make_controller",
    "make_settings",
]
