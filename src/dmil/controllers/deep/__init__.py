"""Deep controllers: networks of neurons in torch, which is loaded when one of them is made."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

from dmil.errors import MissingExtraError


def on_demand(module: str, name: str) -> Callable[..., Any]:
    """Return a function that makes a controller and loads its module only then (ours).

    The table of controllers must not load torch: it takes a second, and it is an optional extra.

    Parameters
    ----------
    module
        Module of this package, such as ``"dqn"``.
    name
        Class of the controller.
    """

    def make(*arguments: Any, **options: Any) -> Any:
        try:
            loaded = import_module(f"{__name__}.{module}")
        except ModuleNotFoundError as error:
            if error.name != "torch":
                raise
            raise MissingExtraError("deep") from None
        return getattr(loaded, name)(*arguments, **options)

    return make
