"""Reading SUMO's XML safely, gzipped or not, with errors that name the line and the column.

A DOCTYPE is refused: SUMO's files need none, and it is what entities are declared in, which can
blow up in memory or read other files. Nothing is ever expanded or loaded from elsewhere.
"""

from __future__ import annotations

import gzip
import zlib
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO
from xml.etree.ElementTree import Element
from xml.parsers import expat
from xml.sax.saxutils import quoteattr

from dmil.errors import InputError

CONTENT = {
    "net": "a SUMO network",
    "routes": "SUMO routes",
    "configuration": "a SUMO configuration",
    "sumoConfiguration": "a SUMO configuration",
    "additional": "SUMO additional definitions",
}
"""Root element to what a file is that has it."""

_CHUNK_BYTES = 1 << 16
_INCLUDE = "include"
_CUT_OFF = {
    expat.errors.codes[message]
    for message in (
        expat.errors.XML_ERROR_NO_ELEMENTS,
        expat.errors.XML_ERROR_UNCLOSED_TOKEN,
        expat.errors.XML_ERROR_PARTIAL_CHAR,
        expat.errors.XML_ERROR_UNCLOSED_CDATA_SECTION,
    )
}

Start = Callable[[str, dict[str, str]], None]
End = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class XmlPlace:
    """Where in a file an element begins, counted from 1 (ours); as text an error's ``where``."""

    path: str
    line: int
    column: int

    def __str__(self) -> str:
        return f"{self.path}, line {self.line}, column {self.column}"


def iter_elements(
    path: str | Path,
    tags: Collection[str],
    *,
    root: Collection[str] = (),
    error: type[InputError] = InputError,
    included_by: tuple[Path, ...] = (),
) -> Iterator[tuple[XmlPlace, Element]]:
    """Read the elements of some names, one after the other, whole with their children (ours).

    The file is read in pieces, so its size does not matter. An element inside another one that is
    given out is only its child. An error may come after the elements in front of it. What a file
    includes (``<include href="…"/>``) is read in its place, as in SUMO.

    Parameters
    ----------
    path
        The file; gzipped ones are recognised by their first bytes.
    tags
        Names of the elements.
    root, error
        See `XmlWalk`.
    included_by
        The files that led to this one by including each other.

    Yields
    ------
    tuple
        Where the element begins, and the element.

    Raises
    ------
    InputError
        As with `XmlWalk.pieces`, or if a file includes itself.
    """
    wanted = frozenset((*tags, _INCLUDE))
    found: list[tuple[XmlPlace, Element]] = []
    open_: list[Element] = []

    def start(name: str, attributes: dict[str, str]) -> None:
        if open_:
            element = Element(name, attributes)
            open_[-1].append(element)
            open_.append(element)
        elif name in wanted:
            open_.append(Element(name, attributes))
            found.append((walk.place, open_[0]))

    def end(name: str) -> None:
        if open_:
            open_.pop()

    walk = XmlWalk(path, start, end, root=root, error=error)
    for _ in walk.pieces():
        complete = len(found) - bool(open_)
        for place, element in found[:complete]:
            if element.tag != _INCLUDE:
                yield place, element
                continue
            chain = (*included_by, Path(path).resolve())
            other = Path(path).parent / element.get("href", "")
            if other.resolve() in chain:
                raise error(
                    f"it includes '{element.get('href', '')}', which leads back to it",
                    where=str(place),
                    expected="files that do not include each other",
                )
            yield from iter_elements(other, tags, root=root, error=error, included_by=chain)
        del found[:complete]


class XmlWalk:
    """One walk through a file, with a call for every element's start and end (ours).

    Parameters
    ----------
    path
        The file; gzipped ones are recognised by their first bytes.
    start
        Called with the name and the attributes of every element that begins.
    end
        Called with the name of every element that ends.
    text
        Called with every piece of text between them.
    root
        Names that the root element usually has. As in SUMO it may have others, but for those
        that another kind of file has, and but for a network's.
    error
        Kind of error to raise.
    """

    def __init__(
        self,
        path: str | Path,
        start: Start,
        end: End,
        *,
        text: End | None = None,
        root: Collection[str] = (),
        error: type[InputError] = InputError,
    ) -> None:
        self._path = Path(path)
        self._roots = root
        self._error = error
        self._start = start
        self._content = _content(root)
        self._empty = True
        self._parser = expat.ParserCreate()
        self._parser.StartElementHandler = self._begin
        self._parser.EndElementHandler = end
        self._parser.CharacterDataHandler = text
        self._parser.StartDoctypeDeclHandler = self._refuse
        self._parser.EntityDeclHandler = self._refuse

    @property
    def place(self) -> XmlPlace:
        """Where the walk is: inside a call, the beginning of that element."""
        line, column = self._parser.CurrentLineNumber, self._parser.CurrentColumnNumber
        return XmlPlace(str(self._path), line, column + 1)

    def run(self) -> None:
        """Walk through the whole file; errors are those of `pieces`."""
        for _ in self.pieces():
            pass

    def pieces(self) -> Iterator[None]:
        """Walk through the file, pausing after every piece of it.

        Raises
        ------
        InputError
            Of the given kind, if the file is missing, unreadable, cut off, not XML, of another
            kind, or has a DOCTYPE.
        """
        for piece in self._read():
            self._empty = self._empty and not piece.strip()
            self._feed(piece, last=False)
            yield
        self._feed(b"", last=True)
        yield

    def _read(self) -> Iterator[bytes]:
        try:
            with self._path.open("rb") as file, _unzipped(file) as stream:
                while piece := stream.read(_CHUNK_BYTES):
                    yield piece
        except FileNotFoundError:
            raise self._wrong("there is no such file", self._path, "check the path") from None
        except EOFError:  # of gzip: there is more to come
            self._empty = False
            raise self._cut_off() from None
        except (gzip.BadGzipFile, zlib.error) as cause:
            problem = f"this is not a sound gzip file ({cause})"
            raise self._wrong(problem, self._path, "copy or download it again") from None
        except OSError as cause:
            raise self._wrong(f"it cannot be read ({cause.strerror})", self._path) from None

    def _feed(self, piece: bytes, *, last: bool) -> None:
        try:
            self._parser.Parse(piece, last)
        except expat.ExpatError as cause:
            if cause.code in _CUT_OFF:
                raise self._cut_off() from None
            raise self._wrong(
                f"this is not XML ({expat.errors.messages[cause.code]})",
                XmlPlace(str(self._path), cause.lineno, cause.offset + 1),
                "check that this is the right file, and correct this place",
            ) from None

    def _begin(self, name: str, attributes: dict[str, str]) -> None:
        self._parser.StartElementHandler = self._start
        # SUMO does not look at the name; one that says that this is something else is a mistake.
        if self._roots and name not in self._roots and ("net" in self._roots or name in CONTENT):
            what = f", so this is {CONTENT[name]}" if name in CONTENT else ""
            problem = f"its root element is <{name}>{what}"
            raise self._wrong(problem, self.place, "check that this is the right file")
        self._start(name, attributes)

    def _refuse(self, *_declaration: object) -> None:
        raise self._error(
            "it has a DOCTYPE, which may declare entities",
            where=str(self.place),
            expected=f"{self._content}, which needs none",
            mend="remove the <!DOCTYPE …> if you trust the file",
        )

    def _cut_off(self) -> InputError:
        problem = "the file is empty" if self._empty else "the file is cut off in the middle"
        place = self._path if self._empty else self.place
        return self._wrong(problem, place, "copy or download it again")

    def _wrong(self, problem: str, place: XmlPlace | Path, mend: str | None = None) -> InputError:
        return self._error(problem, where=str(place), expected=self._content, mend=mend)


def attributes_xml(attributes: Mapping[str, object]) -> str:
    """Return attributes as a start tag has them, each with a blank before it (ours)."""
    return "".join(f" {name}={quoteattr(str(value))}" for name, value in attributes.items())


def _content(root: Collection[str]) -> str:
    if not root:
        return "an XML file"
    kinds = dict.fromkeys(CONTENT.get(name, "an XML file") for name in root)
    return f"{' or '.join(kinds)} (<{'> or <'.join(root)}>)"


def _unzipped(file: BinaryIO) -> BinaryIO:
    zipped = file.read(2) == b"\x1f\x8b"
    file.seek(0)
    return gzip.GzipFile(fileobj=file) if zipped else file  # type: ignore[return-value]
