"""One element of a file: its attributes as numbers and times, with errors that name the place."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from xml.etree.ElementTree import Element, tostring

from dmil.errors import DemandError
from dmil.network.xml_file import XmlPlace

LAST_S = 10**8
"""Latest time that a file may name, three years after its beginning."""


@dataclass(frozen=True, slots=True)
class DemandEntry:
    """A vehicle, trip, flow, route or type as it stands in a file, and where it begins (ours)."""

    place: XmlPlace
    element: Element

    @property
    def id(self) -> str:
        """Its id, which may be empty."""
        return self.element.get("id", "")

    def of_type(self, name: str) -> DemandEntry:
        """Return the same element with another vehicle type."""
        element = Element(self.element.tag, {**self.element.attrib, "type": name})
        element.extend(self.element)
        return DemandEntry(self.place, element)

    def get(self, name: str) -> str | None:
        """Return an attribute as text, None if it is not there."""
        return self.element.get(name)

    def error(
        self,
        problem: str,
        *,
        expected: str | None = None,
        mend: str | None = None,
        kind: type[DemandError] = DemandError,
    ) -> DemandError:
        """Make an error that names the file, the place in it and the element."""
        where = f"{self.place}: {self.element.tag} '{self.id}'"
        return kind(problem, where=where, expected=expected, mend=mend)

    def required(self, name: str) -> str:
        """Return an attribute; a DemandError if it is missing or empty."""
        text = self.element.get(name)
        if not text:
            raise self.error(f"its attribute '{name}' is missing", mend=f'add {name}="…"')
        return text

    def number(self, name: str, *, least: float = 0.0, most: float = math.inf) -> float:
        """Return an attribute as a number; a DemandError unless it is one within the limits."""
        text = self.required(name)
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not (math.isfinite(value) and least <= value <= most):
            limits = f"of {least:g} or more" if most == math.inf else f"from {least:g} to {most:g}"
            raise self.error(f"{name} is '{text}'", expected=f"a number {limits}")
        return value

    def seconds(self, name: str, default: float | None = None) -> float | None:
        """Return an attribute in seconds, a default if it is missing; a DemandError if no time."""
        text = self.element.get(name)
        if text is None:
            return default
        value = seconds_of(text)
        if value is None or not 0 <= value <= LAST_S:
            raise self.error(
                f"{name} is '{text}'",
                expected=f"seconds from 0 to {LAST_S:,}, or hours:minutes:seconds",
            )
        return value


def seconds_of(text: str) -> float | None:
    """Return a time as SUMO writes it in seconds, None if it is no time (SUMO docs: Time).

    It is written such as ``25200``, ``7:00:00`` or ``1:00:00:00`` (days first), and rounded to ms
    as SUMO does.
    """
    try:
        parts = [float(part) for part in text.split(":")]
    except ValueError:
        return None
    if len(parts) not in (1, 3, 4) or not all(map(math.isfinite, parts)):
        return None
    weights = (86400, 3600, 60, 1)[-len(parts) :]
    return round(sum(part * weight for part, weight in zip(parts, weights, strict=True)), 3)


def text_of(element: Element) -> str:
    """Return an element as it is written into a file."""
    return tostring(element, encoding="unicode").strip()


def lines_of(texts: Iterable[str]) -> str:
    """Return elements one a line, without a root element."""
    return "".join(f"{text}\n" for text in texts)
