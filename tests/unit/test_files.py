"""Files appear whole under their name, and in the place of nothing else."""

import os

import pytest

from dmil.errors import OutputError
from dmil.files import held, write_text_atomically


def test_a_file_is_replaced(tmp_path):
    for text in ("one", "two"):
        write_text_atomically(tmp_path / "new" / "file.txt", text)
    assert (tmp_path / "new" / "file.txt").read_text() == "two"
    assert len(list((tmp_path / "new").iterdir())) == 1


def test_a_device_and_a_folder_are_not_replaced(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "folder").mkdir()
    for name, found in (("pipe", "no ordinary file"), ("folder", "it is a folder")):
        with pytest.raises(OutputError, match=found):
            write_text_atomically(tmp_path / name, "text")
    assert (tmp_path / "pipe").is_fifo()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["folder", "pipe"]


def test_a_piece_of_work_is_held_by_one(tmp_path):
    lock, place = tmp_path / "new" / "lock", tmp_path / "work"
    with held(lock, where=place, work="study"):
        refused = pytest.raises(OutputError, match="another process is at work on this study")
        with refused, held(lock, where=place, work="study"):
            pass
        with held(tmp_path / "other", where=place, work="study"):
            pass
    assert not lock.exists()
    with pytest.raises(ValueError, match="as it is"), held(lock, where=place, work="study"):
        raise ValueError("as it is")
    assert not lock.exists()
    (tmp_path / "file").touch()
    refused = pytest.raises(OutputError, match="cannot be made or written")
    with refused, held(tmp_path / "file" / "lock", where=place, work="study"):
        pass
