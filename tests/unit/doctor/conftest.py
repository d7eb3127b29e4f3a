"""Networks and routes of SUMO with something wrong in them."""

import pytest

from dmil.doctor import examine, read_case
from tests.unit.network.conftest import generate, with_states  # noqa: F401  fixtures

NS, EW = "GGgrrrGGgrrr", "rrrGGgrrrGGg"
CLEAR_NS, CLEAR_EW = "yyyrrryyyrrr", "rrryyyrrryyy"
PROGRAM = ((30, NS), (3, CLEAR_NS), (30, EW), (3, CLEAR_EW))
"""Letters are right, straight, left from North, East, South and West."""
LONG_NS = f"{'top0A0 top0A0.80.00'} A0bottom0"
LONG_WE = f"{'left0A0 left0A0.80.00'} A0right0"
EVERY_WAY = "".join(
    f'<flow id="all-{a}-{b}" begin="0" end="600" period="60" from="{a}0A0" to="A0{b}0"/>'
    for a in ("top", "right", "bottom", "left")
    for b in ("top", "right", "bottom", "left")
    if a != b
)
"""A few vehicles on every movement."""


@pytest.fixture
def doctor(tmp_path):
    """A function from a network, and what is inside <routes>, to a diagnosis."""
    pytest.importorskip("sumolib", reason="needs the extra sumo")

    def run(net, routes=None, *, additional=None, **options):
        files = [str(net)]
        if routes is not None:
            path = tmp_path / "a.rou.xml"
            path.write_text(f"<routes>{routes}</routes>")
            files.append(str(path))
        if additional is not None:
            path = tmp_path / "a.add.xml"
            path.write_text(f"<additional>{additional}</additional>")
            files.append(str(path))
        return examine(read_case(files, **options))

    return run


@pytest.fixture(scope="session")
def ingolstadt7():
    """Seven intersections of a real town."""
    pytest.importorskip("sumolib", reason="needs the extra sumo")
    return read_case(["resco/ingolstadt7"])


def of_kind(diagnosis, kind):
    """Return the findings of one kind."""
    return [each for each in diagnosis.findings if each.kind == kind]


def kinds(diagnosis):
    """Return the kinds of all findings, each once, in order."""
    return list(dict.fromkeys(each.kind for each in diagnosis.findings))
