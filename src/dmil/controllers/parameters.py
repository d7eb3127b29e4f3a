"""Settings of controllers, and the tuples of numbers that kernels take from them."""

from __future__ import annotations

from typing import Any, NamedTuple, TypeVar

from pydantic import BaseModel, ConfigDict, Field

GUARD = "Whether it is overruled where shared lanes were blocked; false: the learner as published."
"""What `guard` says of learners."""
Parameters = TypeVar("Parameters", bound=NamedTuple)


class Settings(BaseModel):
    """What a controller is told; the descriptions of its fields are the command line's help."""

    model_config = ConfigDict(frozen=True, extra="forbid")


def with_default(kind: type[BaseModel], name: str, default: Any) -> Any:
    """Return a field of other settings with another default: the same limits and text (ours)."""
    original = kind.model_fields[name]
    field: Any = Field(default, description=original.description)
    field.metadata = list(original.metadata)
    return field


def parameters_of(kind: type[Parameters], settings: BaseModel, **derived: Any) -> Parameters:
    """Return a kernel's tuple: settings by the names of its fields, and what is derived (ours).

    Parameters
    ----------
    kind
        A named tuple. A new setting for a kernel is a field here and in the settings class.
    settings
        Of a controller.
    derived
        Fields that are no settings, or have other values than those of that name.
    """
    fields = {name: getattr(settings, name) for name in kind._fields if name not in derived}
    # To the checker NamedTuple is a function that makes classes.
    filled: Parameters = kind(**fields, **derived)  # type: ignore[call-overload]
    return filled
