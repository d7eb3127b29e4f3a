"""What the episodes of a training came to: in memory, and in a log that is written as they end."""

from __future__ import annotations

import importlib
import json
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from dmil.controllers import Controller
from dmil.errors import InputError, MissingExtraError
from dmil.files import write_text_atomically
from dmil.results.metrics import EPISODE
from dmil.results.schema import RECORDINGS
from dmil.simulation import Observation, Simulator
from dmil.training.loop import Run
from dmil.training.observers import Observer

Row = dict[str, Any]
COLUMNS = tuple(RECORDINGS["training"].schema)
WRITERS = ("tensorboardX", "torch.utils.tensorboard")
"""Modules with a ``SummaryWriter``, the lighter one first."""


class EpisodeRecorder(Observer):
    """Notes what each episode of a training came to (ours).

    Parameters
    ----------
    first
        Number of the first of all episodes.

    Attributes
    ----------
    runs: list of Run
    rows: list of dict
        One for each, columns as of ``training`` in `dmil.results.schema.RECORDINGS`.
    """

    def __init__(self, first: int = 0) -> None:
        self.runs: list[Run] = []
        self.rows: list[Row] = []
        self._first = first

    def begin(self, simulator: Simulator, controller: Controller, seen: Observation) -> None:
        """Begin another episode."""
        self._controller, self._reward_sum = controller, 0.0

    def rewarded(self, reward: npt.NDArray[np.float64]) -> None:
        """Sum up the rewards."""
        self._reward_sum += float(reward.sum())

    def episode_ended(self, episode: int, result: Run) -> None:
        """Note its row."""
        measures, memory = result.measures, result.memory[-1]
        values = (
            self._first + episode,
            result.decisions,
            measures.delay_s,
            measures.travel_time_s,
            measures.wait_per_spawned_s,
            measures.mean_queue_veh,
            memory.entries,
            memory.bytes_total,
            measures.w_over_vc,
            measures.arrived_veh,
            self._reward_sum,
            getattr(self._controller, "epsilon", None),
        )
        self.runs.append(result)
        self.rows.append(dict(zip(COLUMNS, values, strict=True)))

    def study_rows(self) -> list[Row]:
        """Return what a study keeps of them: its own columns of ``episodes.parquet``."""
        return [{name: row[name] for name in ("episode", *EPISODE)} for row in self.rows]


class TrainingLog(EpisodeRecorder):
    """Writes a row for each episode as soon as it is over, episodes counted from 1 (ours).

    Parameters
    ----------
    path
        A file, .csv or .jsonl; without an ending a folder for TensorBoard.
    done
        Episodes that the training has behind it: the rows of these stay, others are replaced.

    Raises
    ------
    InputError
        If the file has another ending.
    MissingExtraError
        If nothing is installed that writes for TensorBoard.
    OutputError
        If the file cannot be written.
    """

    def __init__(self, path: Path, done: int = 0) -> None:
        super().__init__(first=1)
        if path.suffix not in ("", ".csv", ".jsonl"):
            raise InputError(
                f"the log ends in '{path.suffix}'",
                where=str(path),
                expected=".csv, .jsonl, or a folder for TensorBoard, without an ending",
            )
        self._write = _into_file(path, done) if path.suffix else _for_tensorboard(path, done)

    def episode_ended(self, episode: int, result: Run) -> None:
        """Write its row."""
        super().episode_ended(episode, result)
        # What is no number, such as the delay of nobody, is left out.
        self._write(
            {
                name: None if value is None or not math.isfinite(value) else value
                for name, value in self.rows[-1].items()
            }
        )


def _into_file(path: Path, done: int) -> Callable[[Row], None]:
    as_csv = path.suffix == ".csv"
    before = path.read_text(encoding="utf-8").splitlines() if done and path.is_file() else []
    lines = [",".join(COLUMNS)] * as_csv
    lines += [line for line in before if 1 <= int((re.findall(r"\d+", line) or "0")[0]) <= done]

    def write(row: Row | None) -> None:
        if row:
            cells = ("" if value is None else str(value) for value in row.values())
            lines.append(",".join(cells) if as_csv else json.dumps(row))
        write_text_atomically(path, "".join(f"{line}\n" for line in lines))

    write(None)  # a file that cannot be written is found before the first episode
    return write


def _for_tensorboard(folder: Path, done: int) -> Callable[[Row], None]:
    for name in WRITERS:
        try:
            module: Any = importlib.import_module(name)
            break
        except ImportError:
            continue
    else:
        raise MissingExtraError("tensorboard")
    # TensorBoard forgets what an interrupted training wrote of this step and later ones.
    writer = module.SummaryWriter(str(folder), purge_step=done + 1)

    def write(row: Row) -> None:
        for name, value in row.items():
            if value is not None and name != "episode":
                writer.add_scalar(f"training/{name}", value, row["episode"])
        writer.flush()

    return write
