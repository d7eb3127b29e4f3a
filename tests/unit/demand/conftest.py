"""SUMO route files on the roads of a grid."""

import gzip

import pytest

from dmil.demand import read_sumo_routes
from dmil.network import grid

NETWORK = grid(2, 2)
ACROSS = "W0>0,0 0,0>0,1 0,1>E0"
"""From West to East through the upper row."""


@pytest.fixture
def read(tmp_path):
    """A function that writes what is inside <routes> and reads it; its file is ``routes.xml``."""

    def run(text, *, additional=(), zipped=False, root="routes", **options):
        path = tmp_path / "routes.xml"
        content = f"<{root}>\n{escaped(text)}\n</{root}>".encode()
        path.write_bytes(gzip.compress(content) if zipped else content)
        more = []
        for index, other in enumerate(additional):
            more.append(tmp_path / f"{index}.add.xml")
            more[-1].write_text(f"<additional>\n{escaped(other)}\n</additional>")
        return read_sumo_routes(path, NETWORK, additional=more, **options)

    return run


def escaped(text):
    """Links of a grid have a > in their names, which XML allows inside quotes."""
    return text.replace("ACROSS", ACROSS)


def ids(vehicles, vehicle=0):
    """Return the links of one vehicle's route."""
    return [NETWORK.links[k].id for k in vehicles.route(vehicle)]


def kinds(demand):
    """Return kind of remark to (count, example)."""
    return {remark.kind: (remark.count, remark.example) for remark in demand.remarks}
