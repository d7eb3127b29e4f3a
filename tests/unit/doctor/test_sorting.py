from pathlib import Path

import pytest

from dmil.doctor.arguments import sort_arguments
from dmil.errors import InputError


def test_files_are_told_apart_by_what_is_in_them_where_their_roots_do_not_tell(tmp_path):
    case = Path(__file__).parents[2] / "cases" / "additional-root"
    drives = tmp_path / "drives.xml"
    drives.write_text((case / "b.rou.xml").read_text().replace("routes>", "demand>"))
    found = sort_arguments([str(case / "g.net.xml"), str(drives), str(case / "b.add.xml")])
    assert (found.routes, found.additional) == ((drives,), (case / "b.add.xml",))
    drives.write_text("<demand><nobody/></demand>")
    with pytest.raises(InputError, match="its root element is <demand>, and nothing in it is"):
        sort_arguments([str(case / "g.net.xml"), str(drives)])
