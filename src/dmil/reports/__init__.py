"""What people see: figures, pages and what they are drawn with.

The names are loaded when they are first used: a process that only draws needs none of them.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from dmil.reports.export import FORMATS, save_figure, specification

__all__ = ["FORMATS", "save_figure", "specification"]


def __getattr__(name: str) -> Any:
    """Load a public name from its file."""
    if name not in __all__:
        raise AttributeError(f"module 'dmil.reports' has no attribute '{name}'")
    return getattr(importlib.import_module("dmil.reports.export"), name)
