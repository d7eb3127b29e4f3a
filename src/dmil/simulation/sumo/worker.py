"""SUMO in a process of its own: what runs at the other end of `dmil.simulation.sumo.process`.

libsumo allows one simulation per process. This file is run as a program and imports only libsumo
and the standard library, so that it begins in a fraction of a second. It ends when its pipe does,
also if the process at the other end was killed.
"""

from __future__ import annotations

import ctypes
import shutil
import signal
import sys
from array import array
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import libsumo

ACTUATED = "dmil-actuated"
"""Id of the actuated program that is made of an intersection's own one."""
SHORTEST_GREEN_S, LONGEST_GREEN_S = 5, 50
"""Range of a green whose duration the file fixes (SUMO's documentation of actuated programs)."""
MG_PER_G = 1000.0


class Worker:
    """Answers the questions of the process at the other end; every public method is one."""

    def __init__(self) -> None:
        self._own_program: dict[str, str] = {}
        self._flush_outputs: Any = getattr(
            ctypes.CDLL(libsumo._libsumo.__file__), "_ZN12OutputDevice8flushAllEv", None
        )

    def start(self, options: list[str], outputs: dict[str, str]) -> None:
        """Begin a run.

        Parameters
        ----------
        options
            Of the program ``sumo``.
        outputs
            Options of output files that are to be complete whenever they are asked for. A version
            of SUMO that cannot be told to write them out gets its standard output for them, which
            it never holds back; that is slower.
        """
        for option, file in outputs.items():
            options = [*options, option, file if self._flush_outputs else "stdout"]
        libsumo.start(["sumo", *options])
        signals = libsumo.trafficlight
        self._own_program = {name: signals.getProgram(name) for name in signals.getIDList()}

    def advance(
        self, steps: int, programs: list[tuple[str, bool]], switches: list[tuple[int, str, str]]
    ) -> bytes:
        """Simulate some seconds; return what `look` returns after them.

        Parameters
        ----------
        steps
            How many.
        programs
            Signals that follow a program from now on, and whether it is actuated.
        switches
            (second, signal, state string), in the order of the seconds.
        """
        for name, actuated in programs:
            self._follow(name, actuated)
        due = 0
        for second in range(steps):
            while due < len(switches) and switches[due][0] <= second:
                libsumo.trafficlight.setRedYellowGreenState(*switches[due][1:])
                due += 1
            libsumo.simulationStep()
        return self.look()

    def look(self) -> bytes:
        """Return five numbers per vehicle as float64, see `dmil.simulation.sumo.approaches`.

        Asking each vehicle in this process takes half as long as a subscription of all of them:
        libsumo puts subscribed values into nested tables of objects.
        """
        vehicle, seen = libsumo.vehicle, array("d")
        route_index, position = vehicle.getRouteIndex, vehicle.getLanePosition
        speed, road = vehicle.getSpeed, vehicle.getRoadID
        for name in vehicle.getIDList():
            on_junction = road(name).startswith(":")
            seen.extend((int(name), route_index(name), position(name), speed(name), on_junction))
        return seen.tobytes()

    def account(self, emissions: bool) -> bytes:
        """Write all output files out; return six numbers per vehicle in the network as float64.

        These are its number, departure delay in s, time loss in s, stops, CO2 in g and fuel in g.
        """
        if self._flush_outputs:
            self._flush_outputs()
        vehicle, seen = libsumo.vehicle, array("d")
        for name in vehicle.getIDList():
            stops = vehicle.getParameter(name, "device.tripinfo.waitingCount")
            seen.extend((int(name), vehicle.getDepartDelay(name), vehicle.getTimeLoss(name)))
            seen.append(float(stops))
            for kind in ("CO2", "fuel"):
                value = vehicle.getParameter(name, f"device.emissions.{kind}") if emissions else 0
                seen.append(float(value) / MG_PER_G)
        return seen.tobytes()

    def close(self) -> None:
        """End the run; SUMO then writes about vehicles that have not arrived."""
        if libsumo.isLoaded():
            libsumo.close()

    def _follow(self, name: str, actuated: bool) -> None:
        signals, own = libsumo.trafficlight, self._own_program[name]
        wanted = ACTUATED if actuated else own
        if signals.getProgram(name) == wanted:
            return
        logics = {logic.programID: logic for logic in signals.getAllProgramLogics(name)}
        if wanted not in logics:
            logic = logics[own]
            for phase in logic.phases:
                fixed = phase.minDur == phase.maxDur or phase.minDur < 0
                if fixed and set("Gg") & set(phase.state) and "y" not in phase.state.lower():
                    phase.minDur = min(float(SHORTEST_GREEN_S), phase.duration)
                    phase.maxDur = max(float(LONGEST_GREEN_S), phase.duration)
            made = libsumo.trafficlight.Logic(
                wanted, libsumo.constants.TRAFFICLIGHT_TYPE_ACTUATED, 0, logic.phases
            )
            signals.setProgramLogic(name, made)
        signals.setProgram(name, wanted)


def main(handle: int, folder: str) -> None:
    """Answer until the pipe ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the process at the other end decides
    connection, worker = Connection(handle), Worker()
    while True:
        try:
            verb, *arguments = connection.recv()
        except (EOFError, OSError):
            shutil.rmtree(Path(folder), ignore_errors=True)
            return
        try:
            answer = "done", getattr(worker, verb)(*arguments)
        except Exception as error:  # SUMO's own and those of its interface: the other end tells
            answer = "failed", f"{error}"
        connection.send(answer)


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2])
