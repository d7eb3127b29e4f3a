"""SUMO through libsumo and nothing else: what `dmil.benchmarks.sumo` compares with.

Run as a program: reads from standard input, as JSON, the options of ``sumo``, the seconds to
simulate and the switches of the signals as (second, id, state); prints how long its loop took in s.
"""

from __future__ import annotations

import json
import sys
from time import perf_counter

import libsumo


def main() -> None:
    """Run one simulation."""
    options, steps, switches = json.load(sys.stdin)
    libsumo.start(["sumo", *options])
    due: list[list[tuple[str, str]]] = [[] for _ in range(steps)]
    for second, name, state in switches:
        due[second].append((name, state))
    begin = perf_counter()
    for orders in due:
        for name, state in orders:
            libsumo.trafficlight.setRedYellowGreenState(name, state)
        libsumo.simulationStep()
    taken_s = perf_counter() - begin
    libsumo.close()
    print(taken_s)


if __name__ == "__main__":
    main()
