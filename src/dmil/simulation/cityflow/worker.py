"""CityFlow in a process of its own: what runs at the other end of `process`.

The destructor of CityFlow's engine can wait at its barrier for ever, so that an engine is never
destroyed: every run has a process, which ends at once when its pipe does. This file is run as a
program and imports only CityFlow and the standard library.
"""

from __future__ import annotations

import os
import shutil
import signal
import sys
from bisect import bisect_left
from collections import Counter
from multiprocessing.connection import Connection
from typing import Any, NamedTuple

import cityflow

HALTING_M_PER_S = 0.1
"""Slower vehicles halt (CityFlow's own threshold)."""
SHADOW = "_shadow"
"""End of the id of the second body that a vehicle has while it changes lanes."""


class Plan(NamedTuple):
    """All that a run needs; a place is an index into the links of all routes.

    Attributes
    ----------
    config: str
        CityFlow's configuration.
    lanes: list of (str, int)
        Name and link of every lane.
    junction: list of int
        Intersection at the end of every link; −1 where there are no signals.
    length_m, limit_m_per_s: list of float
        Of every link, the length of its lanes and their limit.
    depart_s: list of int
        Of every vehicle, in order.
    top_m_per_s: list of float
        Highest speed of every vehicle.
    offset, route: list of int
        Where the route of a vehicle begins, and the links of all routes.
    slot: list of int
        Of every place, intersection × most + movement at the link's end; −1 if none.
    slots, most: int
        How many slots there are in all and for an intersection.
    within_s: int
        A moving vehicle nearer than this in free flow counts as approaching.
    """

    config: str
    lanes: list[tuple[str, int]]
    junction: list[int]
    length_m: list[float]
    limit_m_per_s: list[float]
    depart_s: list[int]
    top_m_per_s: list[float]
    offset: list[int]
    route: list[int]
    slot: list[int]
    slots: int
    most: int
    within_s: int


class Worker:
    """Drives one run, and follows its vehicles from second to second."""

    def __init__(self, plan: Any) -> None:
        self._plan = Plan(*plan)
        self._engine = cityflow.Engine(self._plan.config, thread_num=1)
        self._time_s = 0
        self._on: list[list[str]] = [[] for _ in self._plan.lanes]
        self._place = list(self._plan.offset[:-1])
        self._link: dict[str, int] = {}
        self._slot: dict[str, int] = {}
        self._pace: dict[str, float] = {}
        self._halting: set[str] = set()
        self._under_way: set[str] = set()
        self._waited: Counter[str] = Counter()
        self._seen: Counter[int] = Counter()
        self._first: dict[tuple[int, str], int] = {}
        self._last: dict[tuple[int, str], int] = {}
        self._passed = [0] * (self._plan.slots // self._plan.most)
        self._count = dict.fromkeys(
            ("arrived_wait_s", "travel_s", "outside_s", "stops", "visits", "entering_s"), 0
        )
        self._loss_s = 0.0
        self._arrived_at: list[int] = []
        self._queued_at: list[int] = []

    def advance(self, steps: int, switches: list[tuple[int, str, int]]) -> dict[str, Any]:
        """Simulate some seconds; ``switches`` are (second, intersection, light phase), in order."""
        self._seen.clear()
        place = 0
        for second in range(steps):
            while place < len(switches) and switches[place][0] <= second:
                self._engine.set_tl_phase(*switches[place][1:])
                place += 1
            self._engine.next_step()
            self._time_s += 1
            self._follow()
        return self._shown(steps)

    def show(self, switches: list[tuple[int, str, int]]) -> None:
        """Show light phases before the run begins."""
        for _, name, phase in switches:
            self._engine.set_tl_phase(name, phase)

    def _follow(self) -> None:
        """Account for the second that has ended."""
        engine, count = self._engine, self._count
        speed = engine.get_vehicle_speed()
        everyone = set(engine.get_vehicles(include_waiting=True))
        self._move(engine.get_lane_vehicles())
        halting = {name for name, moves in speed.items() if moves < HALTING_M_PER_S}
        outside = len(everyone) - len(speed)
        self._waited.update(halting)
        if outside:
            self._waited.update(everyone - speed.keys())
        for name in self._under_way - everyone:
            count["arrived_wait_s"] += self._waited.pop(name, 0)
        self._seen.update(map(self._slot.get, halting))  # type: ignore[arg-type]
        count["stops"] += len(halting - self._halting)
        count["travel_s"] += len(everyone)
        count["outside_s"] += outside
        pace = self._pace
        self._loss_s += sum(max(0.0, 1.0 - moves * pace[name]) for name, moves in speed.items())
        self._halting, self._under_way = halting, everyone
        self._arrived_at.append(bisect_left(self._plan.depart_s, self._time_s) - len(everyone))
        self._queued_at.append(len(halting) + outside)

    def _move(self, lanes: dict[str, list[str]]) -> None:
        """Take in who is on which lane."""
        left: set[str] = set()
        came: dict[str, int] = {}
        for number, (lane, link) in enumerate(self._plan.lanes):
            now, before = lanes[lane], self._on[number]
            if now != before:
                left.update(set(before).difference(now))
                came.update(dict.fromkeys(set(now).difference(before), link))
                self._on[number] = now
        for name in left:
            if not name.endswith(SHADOW) and name not in came:
                self._leave(name)
        for name, link in came.items():
            if name.endswith(SHADOW) or self._link.get(name) == link:
                continue  # it has changed lanes
            if name in self._link:
                self._leave(name)
            self._enter(name, link)
        self._count["entering_s"] += sum(
            self._plan.junction[link] >= 0 for link in self._link.values()
        )

    def _enter(self, name: str, link: int) -> None:
        plan, number = self._plan, _number(name)
        place = self._place[number]
        while plan.route[place] != link and place + 1 < plan.offset[number + 1]:
            place += 1
        self._place[number] = place
        self._link[name] = link
        self._pace[name] = 1.0 / min(plan.limit_m_per_s[link], plan.top_m_per_s[number])
        if plan.slot[place] >= 0:
            self._slot[name] = plan.slot[place]
            self._count["visits"] += 1
        if plan.junction[link] >= 0:
            self._first.setdefault((plan.junction[link], name), self._time_s)

    def _leave(self, name: str) -> None:
        junction = self._plan.junction[self._link.pop(name)]
        slot = self._slot.pop(name, None)
        if slot is not None:
            self._passed[slot // self._plan.most] += 1
            # A route may come by the same link again.
            self._place[_number(name)] += 1
        if junction >= 0:
            self._last[junction, name] = self._time_s

    def _shown(self, steps: int) -> dict[str, Any]:
        plan = self._plan
        queue, near = [0] * plan.slots, [0] * plan.slots
        distance_m = self._engine.get_vehicle_distance()
        for name, slot in self._slot.items():
            if name in self._halting:
                queue[slot] += 1
            elif (plan.length_m[self._link[name]] - distance_m[name]) * self._pace[
                name
            ] <= plan.within_s:
                near[slot] += 1
        halting = self._engine.get_lane_waiting_vehicle_count()
        return self._count | {
            "queue": queue,
            "near": near,
            "waiting": [self._seen[slot] / steps for slot in range(plan.slots)],
            "lane_halting": [halting[lane] for lane, _ in plan.lanes],
            "loss_s": self._loss_s,
            "arrived_at": self._arrived_at[-steps:],
            "queued_at": self._queued_at[-steps:],
            "passed": self._passed,
        }

    def times(self, unfinished_s: int) -> tuple[float, int]:
        """Return the sum over intersections and vehicles of last leaving − first entering, in s.

        A vehicle that has never left the entering lanes of an intersection counts as leaving at
        ``unfinished_s``. Also return how many vehicles have been on such lanes.
        """
        total = sum(self._last.get(key, unfinished_s) - first for key, first in self._first.items())
        return float(total), len({name for _, name in self._first})


def _number(name: str) -> int:
    """Return the number of a vehicle: it is the only one of its flow, ``flow_NUMBER_0``."""
    return int(name[5:-2])


def main(handle: int, folder: str) -> None:
    """Answer until the pipe ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the process at the other end decides
    connection, worker = Connection(handle), None
    while True:
        try:
            verb, *arguments = connection.recv()
            answer: tuple[str, Any]
            try:
                if verb == "start":
                    worker, answer = Worker(*arguments), ("done", None)
                else:
                    answer = "done", getattr(worker, verb)(*arguments)
            except Exception as error:  # the other end tells
                answer = "failed", f"{type(error).__name__}: {error}"
            connection.send(answer)
        except (EOFError, OSError):
            shutil.rmtree(folder, ignore_errors=True)
            os._exit(0)  # without the engine's destructor


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2])
