import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numba
import numpy as np
import pytest
from numba.core.errors import NumbaError

from dmil import compilation
from dmil.compilation import (
    TypedOnce,
    allocating_kernel,
    cache_folder,
    is_cold,
    kernel,
    mark_warm,
)

# Not written out, so that this file's own text holds no kernel.
MARK = "@" + "kernel"


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A package of one kernel and one plain file, in the place of dmil."""
    folder = tmp_path / "package"
    (folder / "room").mkdir(parents=True)
    (folder / "room" / "kernel.py").write_text(f"{MARK}\ndef f(x):\n    return x + 1\n")
    (folder / "plain.py").write_text("def g(x):\n    return x\n")
    monkeypatch.setattr(compilation, "__file__", str(folder / "compilation.py"))
    monkeypatch.setenv("DMIL_CACHE", str(tmp_path / "cache"))
    cache_folder.cache_clear()
    yield folder
    cache_folder.cache_clear()


def folder_now() -> Path:
    cache_folder.cache_clear()
    return cache_folder()


def test_the_same_source_has_the_same_folder(package):
    assert folder_now() == folder_now()


def test_an_edited_kernel_has_another_folder(package):
    before = folder_now()
    path = package / "room" / "kernel.py"
    path.write_text(path.read_text().replace("+ 1", "+ 2"))
    assert folder_now() != before


def test_an_edited_tuple_of_arrays_has_another_folder(package):
    path = package / "state.py"
    path.write_text("FIRST, SECOND = 0, 1\nclass State(NamedTuple):\n    counters: object\n")
    before = folder_now()
    path.write_text(path.read_text().replace("0, 1", "1, 0"))
    assert folder_now() != before


def test_a_moved_kernel_has_another_folder(package):
    before = folder_now()
    (package / "room" / "kernel.py").rename(package / "room" / "other.py")
    assert folder_now() != before


def test_a_file_without_kernels_does_not_count(package):
    before = folder_now()
    (package / "plain.py").write_text("def g(x):\n    return 2 * x\n")
    assert folder_now() == before


def test_another_numba_has_another_folder(package, monkeypatch):
    before = folder_now()
    monkeypatch.setattr(numba, "__version__", "0.0.0")
    assert folder_now() != before


def test_another_python_has_another_folder(package, monkeypatch):
    before = folder_now()
    monkeypatch.setattr(sys.implementation, "cache_tag", "cpython-399")
    assert folder_now() != before


def test_the_base_folder_is_the_users_choice(package, tmp_path, monkeypatch):
    assert folder_now().parent == tmp_path / "cache" / "dmil" / "kernels"
    monkeypatch.delenv("DMIL_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert folder_now().parent == tmp_path / "xdg" / "dmil" / "kernels"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert folder_now().parent == tmp_path / ".cache" / "dmil" / "kernels"


def running_total(values):
    total = np.zeros_like(values)
    for i in range(values.size):
        total[i] = values[i] + (total[i - 1] if i > 0 else 0)
    return total


def add_up(values, total):
    for i in range(values.size):
        total[i] = values[i] + (total[i - 1] if i > 0 else 0)


def test_kernels_compute_what_their_plain_functions_compute():
    values = np.array([3, -1, 4, 1, -5], dtype=np.int64)
    found = np.zeros_like(values)
    kernel(add_up)(values, found)
    np.testing.assert_array_equal(found, running_total(values))
    np.testing.assert_array_equal(allocating_kernel(running_total)(values), found)


class Pair(NamedTuple):
    values: np.ndarray
    total: np.ndarray


def test_a_kernel_that_is_typed_once_does_what_it_does():
    @kernel
    def add_up_pair(pair, more):
        for i in range(pair.values.size):
            pair.total[i] += pair.values[i] + more
        return pair.total.size

    once = TypedOnce(add_up_pair)
    for size, more in ((3, 1), (5, 2)):
        pair, again = (Pair(np.arange(float(size)), np.zeros(size)) for _ in range(2))
        assert once(pair, more) == add_up_pair(again, more) == size
        np.testing.assert_array_equal(pair.total, np.arange(size) + more)
        np.testing.assert_array_equal(pair.total, again.total)


def test_a_kernel_that_is_typed_once_does_not_ask_again(monkeypatch):
    once = TypedOnce(kernel(add_up))
    values, total = np.arange(4.0), np.zeros(4)
    once(values, total)
    monkeypatch.setattr(compilation.Kernel, "compiled_for", None)
    once(values[:2], total[:2])
    np.testing.assert_array_equal(total, [0.0, 1.0, 3.0, 6.0])


def test_only_a_kernel_can_be_typed_once():
    with pytest.raises(AssertionError, match="compiled"):
        TypedOnce(add_up)


def test_a_kernel_that_would_allocate_is_not_compiled():
    def doubled(values):
        return 2 * values

    with pytest.raises(NumbaError):
        kernel(doubled)(np.arange(3))


def test_the_kernels_are_compiled_once(monkeypatch, tmp_path):
    monkeypatch.setattr(compilation, "cache_folder", lambda: tmp_path)
    assert is_cold()
    mark_warm()
    assert not is_cold()


def test_without_a_cache_every_start_compiles(monkeypatch, tmp_path):
    monkeypatch.setattr(compilation, "cache_folder", lambda: tmp_path / "missing" / "folder")
    mark_warm()
    assert is_cold()


def test_a_kernel_divides_as_numpy_does():
    def ratio(a, b):
        return a / b

    assert kernel(ratio)(1.0, 0.0) == np.inf


def test_numbas_own_setting_is_left_as_it_was():
    def one():
        return 1

    before = numba.config.CACHE_DIR
    kernel(one)
    assert before == numba.config.CACHE_DIR


def test_machine_code_is_kept_in_the_folder_and_found_by_the_next_process(tmp_path):
    module = tmp_path / "stranger.py"
    module.write_text(
        "from dmil.compilation import kernel\n\n\n"
        f"{MARK}\ndef twice(x):\n    return 2 * x\n\n\n"
        f"{MARK}\ndef four_times(x):\n    return twice(x) + twice(x)\n\n\n"
        "print(four_times(21))\n"
    )

    def files_after_a_run() -> dict[Path, int]:
        environment = {"DMIL_CACHE": str(tmp_path / "cache"), "PATH": ""}
        command = [sys.executable, str(module)]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
        assert done.stdout == "84\n"
        kept = (tmp_path / "cache" / "dmil" / "kernels").rglob("*.nb?")
        return {path: path.stat().st_mtime_ns for path in kept}

    first = files_after_a_run()
    assert {path.suffix for path in first} == {".nbc", ".nbi"}
    assert files_after_a_run() == first  # what is compiled anew is written anew


def test_a_kernel_is_compiled_once_for_whole_numbers_of_any_width():
    @kernel
    def one_more(x):
        return x + 1

    @kernel
    def sums(narrow, wide):
        return one_more(narrow[0]) + one_more(wide[0]) + one_more(1)

    assert sums(np.array([1], np.int32), np.array([2], np.int64)) == 7
    assert len(one_more._numba_type_.dispatcher.signatures) == 1
    # Called from Python it is compiled as for everybody.
    assert one_more(4) == 5
