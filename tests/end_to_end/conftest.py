"""The command line as a user has it, judged by what it prints and leaves.

Most tests call it in this process, since starting one takes seconds. What only a process shows has
one of its own: shells, signals, Ray, files beside it, and once that both ways say the same.
"""

import io
import json
import os
import subprocess
import sys
from contextlib import chdir, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path

import pytest

from dmil.cli import app
from dmil.experiments.warm_up import compile_kernels

COMMAND = (sys.executable, "-m", "dmil")
PLAIN = {"COLUMNS": "80", "NO_COLOR": "1"}
"""A terminal of fixed width that takes no colours."""


@dataclass(frozen=True)
class Done:
    """How a command ended."""

    code: int
    out: str
    err: str

    @property
    def json(self):
        """The one JSON object on standard output."""
        assert self.out.count("\n") == 1, self.out
        found = json.loads(self.out)
        assert isinstance(found, dict)
        return found

    def checked(self, code):
        assert code in (self.code, None), self.out + self.err
        return self


def environment(**more):
    """The user's environment."""
    return {**os.environ, **PLAIN, **more}


class CommandLine:
    """Runs a command line in a folder and checks its exit code; None is any code."""

    def __call__(self, *arguments, cwd=None, code=0, **variables):
        """Run it in this process, and leave the process as it was."""
        out, err = (io.TextIOWrapper(io.BytesIO(), "utf-8", write_through=True) for _ in "oe")
        known = set(sys.modules)
        with pytest.MonkeyPatch.context() as patch, chdir(cwd or Path.cwd()):
            patch.setattr(sys, "path", [*sys.path])
            for name, value in (PLAIN | variables).items():
                patch.setenv(name, value)
            with redirect_stdout(out), redirect_stderr(err), pytest.raises(SystemExit) as end:
                app([str(each) for each in arguments], prog_name="dmil")
            if cwd:
                _forget_modules_of(Path.cwd(), known)
        printed = (each.buffer.getvalue().decode() for each in (out, err))
        return Done(end.value.code or 0, *printed).checked(code)

    def process(self, *arguments, cwd=None, code=0, **variables):
        """Run it in a process of its own."""
        done = subprocess.run(
            [*COMMAND, *map(str, arguments)],
            cwd=cwd,
            env=environment(**variables),
            capture_output=True,
            text=True,
            check=False,
        )
        return Done(done.returncode, done.stdout, done.stderr).checked(code)


def _forget_modules_of(folder, known):
    """Forget what was found in a test's folder: the next may have a module of the same name."""
    for name in set(sys.modules) - known:
        file = getattr(sys.modules[name], "__file__", None)
        if file and Path(file).is_relative_to(folder):
            del sys.modules[name]


@pytest.fixture(scope="session")
def dmil():
    """Run a command line; what a first start says is not part of any test."""
    compile_kernels()
    return CommandLine()


@pytest.fixture(scope="session")
def policy(dmil, tmp_path_factory) -> Path:
    """A policy for a 1×2 grid."""
    path = tmp_path_factory.mktemp("policy") / "policy.npz"
    dual = ("--controller", "dual-memory")
    dmil("train", "--scenario", "grid:1x2", *dual, "--episodes", 3, "--out", path, "--no-compare")
    return path


@pytest.fixture
def city(tmp_path):
    """CityFlow files of one crossing of four roads, to be spoilt and written."""

    def road(name, start, end, points):
        lane = {"width": 4, "maxSpeed": 10}
        ends = {"startIntersection": start, "endIntersection": end}
        return {"id": name, "points": points, "lanes": [lane] * 3, **ends}

    sides = {"E": (200, 0), "N": (0, 200), "W": (-200, 0), "S": (0, -200)}
    middle = {"x": 0, "y": 0}
    nodes, roads, links = [], [], []
    for i, (side, (x, y)) in enumerate(sides.items()):
        outside = {"x": x, "y": y}
        nodes.append({"id": side, "point": outside, "roadLinks": [], "virtual": True})
        roads.append(road(f"{side}_in", side, "c", [outside, middle]))
        roads.append(road(f"{side}_out", "c", side, [middle, outside]))
        across = "ENWS"[(i + 2) % 4]
        links.append(
            {
                "type": "go_straight",
                "startRoad": f"{side}_in",
                "endRoad": f"{across}_out",
                "laneLinks": [{"startLaneIndex": 1, "endLaneIndex": 1}],
            }
        )
    phases = [
        {"time": 5, "availableRoadLinks": []},
        {"time": 30, "availableRoadLinks": [0, 2]},
        {"time": 30, "availableRoadLinks": [1, 3]},
    ]
    crossing = {"id": "c", "point": middle, "roadLinks": links, "virtual": False}
    crossing["trafficLight"] = {"lightphases": phases}
    roadnet = {"intersections": [crossing, *nodes], "roads": roads}
    vehicle = {"length": 5, "minGap": 2.5}
    flow = [
        {
            "vehicle": vehicle,
            "route": [f"{a}_in", f"{b}_out"],
            "interval": 1,
            "startTime": time,
            "endTime": time,
        }
        for time in range(0, 500, 5)
        for a, b in (("E", "W"), ("N", "S"))
    ]

    def write(spoil=None):
        if spoil:
            spoil(roadnet, flow)
        (tmp_path / "roadnet.json").write_text(json.dumps(roadnet))
        (tmp_path / "flow.json").write_text(json.dumps(flow))
        return tmp_path

    return write
