"""Safe XML: what is cut off, not XML or dangerous is refused, with line and column."""

from __future__ import annotations

import gzip
from pathlib import Path

import pytest

from dmil.errors import DemandError, InputError, NetworkError
from dmil.network.xml_file import iter_elements

ROUTES = """<?xml version="1.0" encoding="UTF-8"?>
<!-- a comment -->
<routes>
    <vType id="car" accel="2.6"/>
    <vehicle id="v0" depart="1">
        <route edges="a b"/>
        <vehicle id="inner"/>
    </vehicle>
    <trip id="t0"/>
</routes>
"""


def write(folder: Path, text: str | bytes) -> Path:
    path = folder / "file.xml"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return path


def failure(path: Path, root: tuple[str, ...] = ("net",)) -> NetworkError:
    with pytest.raises(NetworkError) as caught:
        list(iter_elements(path, (), root=root, error=NetworkError))
    return caught.value


@pytest.mark.parametrize("zipped", [False, True])
def test_elements_come_whole_in_order_with_their_place(tmp_path: Path, zipped: bool) -> None:
    text = ROUTES.encode()
    path = write(tmp_path, gzip.compress(text) if zipped else text)
    found = list(iter_elements(path, ("vehicle", "trip"), root=("routes",)))
    assert [(place.line, place.column, element.attrib["id"]) for place, element in found] == [
        (5, 5, "v0"),
        (9, 5, "t0"),
    ]
    assert [child.tag for child in found[0][1]] == ["route", "vehicle"]


def test_elements_longer_than_a_piece_of_the_file(tmp_path: Path) -> None:
    stops = "<stop/>" * 30_000
    path = write(tmp_path, f"<routes><vehicle>{stops}</vehicle><vehicle/></routes>")
    assert [len(element) for _, element in iter_elements(path, ("vehicle",))] == [30_000, 0]


def test_billion_laughs_is_refused_where_it_stands(tmp_path: Path) -> None:
    entities = "".join(f'<!ENTITY l{i} "{f"&l{i - 1};" * 10}">' for i in range(1, 10))
    text = f'<?xml version="1.0"?>\n<!DOCTYPE net [<!ENTITY l0 "ha">{entities}]>\n<net>&l9;</net>'
    error = failure(write(tmp_path, text))
    assert "DOCTYPE" in error.problem
    assert "line 2" in str(error.where)


def test_external_entity_is_not_read(tmp_path: Path) -> None:
    secret = tmp_path / "secret"
    secret.write_text("<edge/>")
    text = f'<!DOCTYPE net [<!ENTITY x SYSTEM "{secret.as_uri()}">]><net>&x;</net>'
    assert "DOCTYPE" in failure(write(tmp_path, text)).problem


def test_undeclared_entity_is_not_xml(tmp_path: Path) -> None:
    assert "not XML" in failure(write(tmp_path, "<net>&x;</net>")).problem


@pytest.mark.parametrize("length", [10, 60, 100, 150, len(ROUTES) - 3])
def test_cut_off_anywhere(tmp_path: Path, length: int) -> None:
    error = failure(write(tmp_path, ROUTES[:length]), ("routes",))
    assert error.problem == "the file is cut off in the middle"
    assert "line" in str(error.where)


def test_cut_off_gzip(tmp_path: Path) -> None:
    text = gzip.compress(ROUTES.encode())
    assert "cut off" in failure(write(tmp_path, text[:-30]), ("routes",)).problem


def test_damaged_gzip(tmp_path: Path) -> None:
    text = bytearray(gzip.compress(ROUTES.encode()))
    text[20:40] = bytes(20)
    assert "gzip" in failure(write(tmp_path, bytes(text)), ("routes",)).problem


def test_not_xml_names_line_and_column(tmp_path: Path) -> None:
    error = failure(write(tmp_path, '<net>\n  <edge id="a"></lane>\n</net>'))
    assert "not XML (mismatched tag)" in error.problem
    assert str(error.where).endswith("line 2, column 18")
    assert "not XML" in failure(write(tmp_path, '{"intersections": []}')).problem
    assert "not XML" in failure(write(tmp_path, b"\x00\x01\x02\x03")).problem


def test_something_behind_the_end_is_not_xml(tmp_path: Path) -> None:
    assert "not XML" in failure(write(tmp_path, "<net/><net/>")).problem


def test_empty_missing_and_folder(tmp_path: Path) -> None:
    assert "empty" in failure(write(tmp_path, " \n ")).problem
    assert "no such file" in failure(tmp_path / "none.net.xml").problem
    assert "cannot be read" in failure(tmp_path).problem


def test_another_root_element_says_what_the_file_is(tmp_path: Path) -> None:
    error = failure(write(tmp_path, ROUTES))
    assert error.problem == "its root element is <routes>, so this is SUMO routes"
    assert error.expected == "a SUMO network (<net>)"
    assert str(error.where).endswith("line 3, column 1")


def test_kind_of_error_is_the_callers(tmp_path: Path) -> None:
    path = write(tmp_path, "<net>")
    with pytest.raises(DemandError):
        list(iter_elements(path, ("edge",), error=DemandError))
    with pytest.raises(InputError):
        list(iter_elements(path, ()))


def test_other_encodings_are_understood(tmp_path: Path) -> None:
    text = '<?xml version="1.0" encoding="{}"?><net><edge id="Süd"/></net>'
    for encoding in ("iso-8859-1", "utf-16", "utf-8-sig"):
        declared = encoding.removesuffix("-sig")
        path = write(tmp_path, text.format(declared).encode(encoding))
        assert [e.attrib["id"] for _, e in iter_elements(path, ("edge",))] == ["Süd"]
