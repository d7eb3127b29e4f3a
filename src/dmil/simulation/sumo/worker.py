"""SUMO in a process of its own: what runs at the other end of `dmil.simulation.sumo.process`.

libsumo allows one simulation per process. This file is run as a program and imports only libsumo
and the standard library, so that it begins in a fraction of a second. It ends when its pipe does,
also if the process at the other end was killed.
"""

from __future__ import annotations

import ctypes
import os
import shutil
import signal
import sys
from array import array
from collections.abc import Sequence
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import libsumo

ACTUATED = "dmil-actuated"
"""Id of the actuated program that is made of an intersection's own one."""
HELD_WITHIN_M = 50.0
"""In a closed lane the first vehicle is held so far before the stop line at most."""
SHORTEST_GREEN_S, LONGEST_GREEN_S = 5.0, 50.0
"""Range of a green whose duration the file fixes; netconvert's own for actuated programs."""


class Worker:
    """Answers the questions of the process at the other end; every public method is one."""

    def __init__(self) -> None:
        self._own_program: dict[str, str] = {}
        self._route: dict[str, str] = {}
        self._closed: dict[str, float] = {}
        self._held: set[str] = set()
        self._stops = False
        self._meso, self._longest_crossing_m = False, 0.0
        self._flush_outputs: Any = getattr(
            ctypes.CDLL(libsumo._libsumo.__file__), "_ZN12OutputDevice8flushAllEv", None
        )

    def start(self, options: list[str], stops: bool = False) -> None:
        """Begin a run with options of the program ``sumo``; say whether vehicles have stops."""
        libsumo.start(["sumo", *options])
        self._stops = stops
        self._meso = "--mesosim" in options
        lanes = libsumo.lane
        crossings_m = [lanes.getLength(name) for name in lanes.getIDList() if name[0] == ":"]
        self._longest_crossing_m = max(crossings_m, default=0.0)
        signals = libsumo.trafficlight
        self._own_program = {name: signals.getProgram(name) for name in signals.getIDList()}

    def advance(
        self, steps: int, programs: list[tuple[str, bool]], switches: list[tuple[int, str, str]]
    ) -> tuple[bytes, dict[int, tuple[str, ...]]]:
        """Simulate some seconds; return what `look` and `elsewhere` return after them.

        ``programs`` are signals that follow a program from now on, and whether it is actuated,
        ``switches`` (second, signal, state string), in the order of the seconds.
        """
        for name, actuated in programs:
            self._follow(name, actuated)
        begin_s = libsumo.simulation.getTime()
        done = 0
        for second, name, state in switches:
            if done < second < steps:
                self._simulate(begin_s + second)
                done = second
            if second < steps:
                libsumo.trafficlight.setRedYellowGreenState(name, state)
        self._simulate(begin_s + steps)
        names = _measured()
        return self.look(names), self.elsewhere(names)

    def close_lane(self, name: str, until_s: float) -> None:
        """Let no vehicle leave a lane until a time of SUMO's."""
        self._closed[name] = max(self._closed.get(name, until_s), until_s)

    def _simulate(self, until_s: float) -> None:
        """Simulate until a time, second by second while lanes are closed."""
        while self._closed and libsumo.simulation.getTime() < until_s:
            self._hold(libsumo.simulation.getTime())
            libsumo.simulationStep()
        if libsumo.simulation.getTime() < until_s:
            libsumo.simulationStep(until_s)

    def _hold(self, time_s: float) -> None:
        """Hold the first vehicle of every closed lane at its stop line, and let others go.

        It brakes as it can; one that has changed lanes, and all when the lane opens, drive on.
        """
        vehicle, lanes = libsumo.vehicle, libsumo.lane
        self._closed = {name: end_s for name, end_s in self._closed.items() if end_s > time_s}
        first: set[str] = set()
        for name in self._closed:
            there = lanes.getLastStepVehicleIDs(name)
            front = max(there, key=vehicle.getLanePosition, default=None)
            held_from_m = lanes.getLength(name) - HELD_WITHIN_M
            if front is not None and vehicle.getLanePosition(front) >= held_from_m:
                first.add(front)
        for each in (self._held - first) & set(vehicle.getIDList()):
            vehicle.setSpeed(each, -1)
        for each in first - self._held:
            vehicle.setSpeed(each, 0)
        self._held = first

    def look(self, names: Sequence[str]) -> bytes:
        """Return five rows with a number per vehicle as float64, see `approaches.count_vehicles`.

        All are read in one go per decision. Asking each vehicle in this process takes half as long
        as a context subscription of all of them, whose values come in nested tables of objects. Who
        is further on its lane than any lane over a junction is long need not be asked for its road.
        """
        vehicle = libsumo.vehicle
        seen = array("d", map(int, names))
        seen.extend(map(vehicle.getRouteIndex, names))
        positions_m = list(map(vehicle.getLanePosition, names))
        seen.extend(positions_m)
        seen.extend(map(self._speed, names) if self._stops else map(vehicle.getSpeed, names))
        longest_m, road = self._longest_crossing_m, vehicle.getRoadID
        seen.extend(
            [
                at_m <= longest_m and road(name).startswith(":")
                for name, at_m in zip(names, positions_m, strict=True)
            ]
        )
        return seen.tobytes()

    @staticmethod
    def _speed(name: str) -> float:
        """Return a speed, −1 at a stop: who stands there waits for no signal."""
        vehicle = libsumo.vehicle
        return -1.0 if vehicle.isStopped(name) else vehicle.getSpeed(name)

    def elsewhere(self, names: Sequence[str]) -> dict[int, tuple[str, ...]]:
        """Return the vehicles that have got another route since the last call, and its edges.

        SUMO calls the route in a vehicle's element "!" and the vehicle's id, and every other
        one otherwise, so that comparing names is enough.
        """
        vehicle, found = libsumo.vehicle, {}
        for name, route in zip(names, map(vehicle.getRouteID, names), strict=True):
            if route != "!" + name and route != self._route.get(name):
                self._route[name] = route
                found[int(name)] = vehicle.getRoute(name)
        return found

    def account(self) -> bytes:
        """Write all output files out; return five numbers per vehicle in the network as float64.

        These are its number, departure delay, time loss and time halting in s, and stops. A version
        of SUMO that cannot be told to write keeps arrivals back for a while; after the run all are
        there.
        """
        if self._flush_outputs:
            self._flush_outputs()
        vehicle, seen = libsumo.vehicle, array("d")
        for name in _measured():
            halting_s = float(vehicle.getParameter(name, "device.tripinfo.waitingTime"))
            if self._meso:
                # The device adds a halt of the mesoscopic model when it is over.
                halting_s += vehicle.getWaitingTime(name)
            stops = int(vehicle.getParameter(name, "device.tripinfo.waitingCount"))
            delay_s, loss_s = vehicle.getDepartDelay(name), vehicle.getTimeLoss(name)
            seen.extend((int(name), delay_s, loss_s, halting_s, stops))
        return seen.tobytes()

    def close(self) -> None:
        """End the run; SUMO then writes about vehicles that have not arrived."""
        if libsumo.isLoaded():
            libsumo.close()

    def _follow(self, name: str, actuated: bool) -> None:
        signals, own = libsumo.trafficlight, self._own_program[name]
        logics = {logic.programID: logic for logic in signals.getAllProgramLogics(name)}
        fixed = logics[own].type == libsumo.constants.TRAFFICLIGHT_TYPE_STATIC
        wanted = ACTUATED if actuated and fixed else own
        if wanted not in logics:
            signals.setProgramLogic(name, _actuated(logics[own]))
        if signals.getProgram(name) != wanted:
            signals.setProgram(name, wanted)


def _measured() -> list[str]:
    """Return the vehicles in the network that are a run's own: their ids are numbers."""
    return [name for name in libsumo.vehicle.getIDList() if name.isdecimal()]


def _actuated(logic: Any) -> Any:
    """Return the actuated program of a fixed-time one, as SUMO makes it when it loads one.

    A green keeps the range of durations that the file gives it.
    """
    for phase in logic.phases:
        letters = set(phase.state)
        if phase.minDur == phase.maxDur and letters & set("Gg") and not letters & set("yY"):
            phase.minDur, phase.maxDur = SHORTEST_GREEN_S, LONGEST_GREEN_S
        phase.duration = phase.minDur  # of the stage that it begins with
    return libsumo.trafficlight.Logic(
        ACTUATED, libsumo.constants.TRAFFICLIGHT_TYPE_ACTUATED, 0, logic.phases
    )


def main(handle: int, folder: str) -> None:
    """Answer until the pipe ends, each run in a fork of this process.

    What a run leaves behind in SUMO's memory changes the next one a little: its results then depend
    on what was simulated before. A fork begins every run alike, and takes milliseconds.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the process at the other end decides
    connection = Connection(handle)
    while True:
        try:
            verb, *arguments = connection.recv()
        except (EOFError, OSError):
            shutil.rmtree(Path(folder), ignore_errors=True)
            return
        if verb != "start":  # there is no run
            connection.send(("done", None))
        elif (child := os.fork()) == 0:
            _run(connection, arguments)
            os._exit(0)
        elif code := os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]):
            os._exit(code if code > 0 else 128 - code)  # as SUMO ended, so that the other end sees


def _run(connection: Connection, arguments: list[Any]) -> None:
    """Answer for one run, until it is closed, has failed, or the pipe ends."""
    worker, verb = Worker(), "start"
    while True:
        try:
            answer = "done", getattr(worker, verb)(*arguments)
        except Exception as error:  # SUMO's own and those of its interface: the other end tells
            answer = "failed", f"{error}"
        try:
            connection.send(answer)
            if verb == "close" or answer[0] == "failed":
                return
            verb, *arguments = connection.recv()
        except (EOFError, OSError):
            return


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2])
