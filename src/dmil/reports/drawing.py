"""Draw charts in processes of their own, while this one still works on the next ones.

The drawing library keeps Python's lock, so threads would not help. The processes run this module,
which imports little, and never the user's script, so that a script needs no special care.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import vl_convert

from dmil.errors import OutputError

PICTURE_FORMATS = ("svg", "png", "pdf")
PNG_SCALE = 2.0
PROCESSES = 2


def draw(spec: dict[str, Any], formats: Sequence[str] = PICTURE_FORMATS) -> dict[str, bytes]:
    """Draw a Vega-Lite specification once and return it in several picture formats."""
    svg = vl_convert.vegalite_to_svg(spec, allowed_base_urls=[])
    drawn: dict[str, Callable[[], bytes]] = {
        "svg": svg.encode,
        "png": lambda: bytes(vl_convert.svg_to_png(svg, scale=PNG_SCALE)),
        "pdf": lambda: bytes(vl_convert.svg_to_pdf(svg)),
    }
    return {format: drawn[format]() for format in formats}


class DrawingProcesses:
    """Draws charts in the background; use it as a context manager."""

    def __enter__(self) -> DrawingProcesses:
        self._folder = tempfile.TemporaryDirectory(prefix="dmil-figures-")
        self._workers: list[subprocess.Popen[str]] = []
        self._names: list[str] = []
        return self

    def __exit__(self, *exception: object) -> None:
        for worker in self._workers:
            worker.kill()
            worker.communicate()
        self._folder.cleanup()

    def draw(self, name: str, spec: dict[str, Any]) -> None:
        """Begin to draw a specification."""
        Path(self._folder.name, f"{name}.json").write_text(json.dumps(spec), encoding="utf-8")
        if len(self._workers) < PROCESSES:
            command = [sys.executable, "-P", "-m", __name__, self._folder.name]
            self._workers.append(
                subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            )
        worker = self._workers[len(self._names) % PROCESSES]
        self._names.append(name)
        assert worker.stdin is not None, "it was opened with a pipe"
        try:
            worker.stdin.write(f"{name}\n")
            worker.stdin.flush()
        except BrokenPipeError:
            raise self._failure(worker) from None

    def pictures(self) -> dict[str, bytes]:
        """Wait for all drawings; return them by file name.

        Raises
        ------
        OutputError
            If a drawing failed.
        """
        for worker in self._workers:
            _, errors = worker.communicate()
            if worker.returncode:
                raise self._failure(worker, errors)
        return {
            f"{name}.{format}": Path(self._folder.name, f"{name}.{format}").read_bytes()
            for name in self._names
            for format in PICTURE_FORMATS
        }

    def _failure(self, worker: subprocess.Popen[str], errors: str | None = None) -> OutputError:
        errors = worker.communicate()[1] if errors is None else errors
        last = errors.strip().splitlines()[-1:] or [f"exit code {worker.returncode}"]
        return OutputError(f"a figure could not be drawn ({last[0]})", where="report")


def draw_named(folder: Path, names: Iterable[str]) -> None:
    """Draw ``NAME.json`` of a folder for every name, into files beside it."""
    for line in names:
        name = line.strip()
        spec = json.loads((folder / f"{name}.json").read_text(encoding="utf-8"))
        for format, data in draw(spec).items():
            (folder / f"{name}.{format}").write_bytes(data)


if __name__ == "__main__":
    draw_named(Path(sys.argv[1]), sys.stdin)
