"""Settings whose wrong values raise our error."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict, ValidationError

from dmil.errors import InputError
from dmil.network.json_file import first_problem


class Settings(BaseModel):
    """Frozen numbers of a scenario; a wrong one raises our error and not pydantic's."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    def __init__(self, **values: Any) -> None:
        try:
            super().__init__(**values)
        except ValidationError as cause:
            place, problem = first_problem(cause)
            fields = ", ".join(type(self).model_fields)
            name = type(self).__name__
            raise InputError(
                problem,
                where=f"{name}.{place}" if place else name,
                mend=f"{name} has the fields {fields}",
            ) from None
