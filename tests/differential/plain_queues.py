"""The queue simulator in plain Python: dicts, deques, one object per vehicle.

It was written from the specification (§2) and the docstrings. It counts headways in exact
fractions, where the kernel has floating-point numbers.
"""

from collections import defaultdict, deque
from dataclasses import dataclass, field
from fractions import Fraction
from math import floor, inf

from dmil.scenarios import signal_times
from dmil.simulation.queue.gaps import IN_TURN_S, gap_of, in_turn
from dmil.simulation.queue.right_of_way import LONGEST_GAP_S


@dataclass(eq=False)
class Car:
    number: int
    route: list[int]
    kind: int | None
    place: int = 0
    joined: int = 0
    waited: int = 0
    arrived: int = -1


@dataclass
class Light:
    shown: int | None = None
    green_from: int = 0
    go_from: dict[int, int] = field(default_factory=dict)


class PlainQueues:
    """The queue simulator, as one would explain it."""

    def __init__(self, scenario, vehicles):
        self.network, self.rules = scenario.network, scenario.timing
        self.times = signal_times(scenario.timing, scenario.network)
        self.now = self.overruled = self.visits = self.waiting_steps = self.blocked = 0
        self.outside_steps = self.stops = self.yielded = self.impatient = 0
        self.gap_wait = scenario.dynamics.gap_wait_s
        self.wave, self.started = Fraction(scenario.dynamics.start_wave_veh_per_s), 0
        self.lights = [Light() for _ in self.network.intersections]
        flow = Fraction(scenario.dynamics.saturation_flow_veh_per_s).limit_denominator(50)
        self.headway, self.ready = 1 / flow, defaultdict(Fraction)
        self.lanes, self.lanes_of = {}, {}
        self.nodes = [*self.network.intersections, *self.network.junctions]
        self.places = {}
        for i, node in enumerate(self.nodes):
            for j, movement in enumerate(node.movements):
                first, onto = (
                    self.network.link_index[name] for name in (movement.from_link, movement.to_link)
                )
                self.places[first, onto] = i, j
                chosen = movement.lanes
                if i >= len(self.lights):
                    chosen = chosen[-self.network.links[onto].lanes :]
                self.lanes_of[i, j, None] = [(movement.from_link, k) for k in chosen]
        for i, node in enumerate(self.network.intersections):
            for j, movement in enumerate(node.movements):
                for kind, classes in enumerate(scenario.sumo.classes if scenario.sumo else ()):
                    ways = self.network.permissions.ways[movement.from_link, movement.to_link]
                    mine = [k for k in sorted(ways) if classes <= ways[k]] or movement.lanes
                    self.lanes_of[i, j, kind] = [(movement.from_link, k) for k in mine]
        for lanes in self.lanes_of.values():
            for lane in lanes:
                self.lanes.setdefault(lane, deque())
        self.went, self.soonest = {}, {}
        self.short_gaps = self.turns = self.behind = 0
        self.waited_at = defaultdict(int)
        self.time_on, self.most_on = {}, {}
        for number, link in enumerate(self.network.links):
            self.time_on[number] = self._travel_time(link)
            self.most_on[number] = self._capacity(link, scenario.dynamics)
        self.on_link = {number: set() for number in self.time_on}
        self.moving = {number: deque() for number in self.time_on}
        self.outside = {number: deque() for number in self.time_on}
        kinds = [None] * len(vehicles) if vehicles.kind is None else vehicles.kind.tolist()
        self.cars = [Car(v, vehicles.route(v).tolist(), kind) for v, kind in enumerate(kinds)]
        self.departing = defaultdict(list)
        for car, second in zip(self.cars, vehicles.depart_s.tolist(), strict=True):
            self.departing[second].append(car)

    def _travel_time(self, link):
        seconds = round(link.length_m / link.speed_m_per_s)
        if link.start in self.network.fringe or link.end in self.network.fringe:
            return seconds
        return max(1, seconds)

    def _capacity(self, link, dynamics):
        if not dynamics.storage or link.length_m == 0 or link.end in self.network.fringe:
            return float("inf")
        return max(1, int(link.length_m * link.open_lanes / dynamics.vehicle_space_m))

    def decide(self, wanted):
        """Change the lights as far as the rules allow."""
        self.waited_at.clear()
        nodes = zip(self.network.intersections, self.lights, wanted, strict=True)
        for i, (node, light, phase) in enumerate(nodes):
            green_s, first, before = self.now - light.green_from, light.shown is None, light.shown
            longest_s = 0 if first else self.times.max_green_s[i][before]
            if phase == light.shown:
                if not longest_s or green_s < longest_s or len(node.phases) == 1:
                    continue
                self.overruled += 1
                phase = (phase + 1) % len(node.phases)
            elif not first and green_s < self.times.min_green_s[i][before]:
                self.overruled += 1
                continue
            light.shown = phase
            light.green_from = self.now + (
                0 if first else int(self.times.clearance_s[i][before][phase])
            )
            had_green, light.go_from = light.go_from, {}
            if self.times.all_stop[i] and not first:
                had_green = {}
            for j in node.phases[phase]:
                light.go_from[j] = had_green.get(j, light.green_from + self.rules.startup_lost_s)
            for j in node.unsignalled:
                light.go_from[j] = 0

    def step(self):
        """Departures, ends of links, discharge, measurements."""
        for car in self.departing[self.now]:
            car.joined = self.now
            self.outside[car.route[0]].append(car)
        for link, queue in self.outside.items():
            while queue and self.room_on(link):
                car = queue.popleft()
                car.waited += self.now - car.joined
                self.enter(car)
        for moving in self.moving.values():
            while moving and moving[0][0] == self.now:
                self.reach_end(moving.popleft()[1])
        self.soonest = {}
        for moving in self.moving.values():
            for due, car in moving:
                if due <= self.now + LONGEST_GAP_S and car.place < len(car.route) - 1:
                    place = self.place_of(car)
                    self.soonest[place] = min(due, self.soonest.get(place, inf))
        for lane, queue in self.lanes.items():
            self.discharge(lane, queue)
        for place, count in self.queued().items():
            self.waited_at[place] += count
        self.waiting_steps += sum(map(len, self.lanes.values())) + self.waiting_outside
        self.outside_steps += self.waiting_outside
        self.now += 1

    def discharge(self, lane, queue):
        while queue and self.ready[lane] < self.now + 1:
            car = queue[0]
            place = self.place_of(car)
            if not self.has_green(place) or self.must_yield(car, lane, place):
                return
            if not self.room_on(car.route[car.place + 1]):
                self.blocked += 1
                return
            queue.popleft()
            self.ready[lane] = max(self.ready[lane], self.now) + self.headway_at(place)
            self.went[place] = self.now
            car.waited += self.now - car.joined
            self.stops += self.now > car.joined
            self.on_link[car.route[car.place]].remove(car)
            car.place += 1
            self.enter(car)

    def headway_at(self, place):
        if not self.is_junction(place) or not self.foes(place):
            return self.headway
        follow = gap_of(self.nodes[place[0]], place[1])[1]
        return max(self.headway, Fraction(str(follow)))

    def is_junction(self, place):
        return place[0] >= len(self.lights)

    def foes(self, place):
        gives_way = self.nodes[place[0]].gives_way
        return [(place[0], k) for k in gives_way[place[1]]] if gives_way else []

    def has_green(self, place):
        if self.is_junction(place):
            return True
        return self.now >= self.lights[place[0]].go_from.get(place[1], float("inf"))

    def must_yield(self, car, lane, place):
        if self.is_junction(place) and any(self.too_soon(place, foe) for foe in self.foes(place)):
            return True
        if not any(
            self.has_green(foe)
            and self.anyone_for(foe)
            and (not self.in_turn(place, foe) or self.came_first(foe, place, lane))
            for foe in self.foes(place)
        ):
            return False
        if self.now - max(self.ready[lane], car.joined) >= self.gap_wait:
            self.impatient += 1
            return False
        self.yielded += 1
        return True

    def in_turn(self, place, foe):
        return self.is_junction(place) and in_turn(self.nodes[place[0]], place[1], foe[1])

    def too_soon(self, place, foe):
        """Whether a gap is too short: behind the last one that is seen, or before the next."""
        node = self.nodes[place[0]]
        critical = gap_of(node, place[1])[0]
        link = self.network.links[self.network.link_index[node.movements[foe[1]].from_link]]
        near = link.start not in self.network.fringe
        seen = max(1, round(link.length_m / link.speed_m_per_s)) if near else inf
        in_turn = self.in_turn(place, foe)
        after = IN_TURN_S[0] if in_turn else max(0, critical - seen)
        if self.went.get(foe, -inf) + after > self.now:
            self.turns += in_turn
            self.behind += not in_turn
            return True
        short = not in_turn and self.soonest.get(foe, inf) < self.now + critical
        self.short_gaps += short
        return short

    def came_first(self, foe, place, lane):
        mine = self.first_since(lane), place[1]
        return any(
            (self.first_since(other), foe[1]) < mine
            for other in self.lanes_of[*foe, None]
            if self.lanes[other] and self.place_of(self.lanes[other][0]) == foe
        )

    def first_since(self, lane):
        return floor(max(self.ready[lane], self.lanes[lane][0].joined))

    def place_of(self, car):
        return self.places[car.route[car.place], car.route[car.place + 1]]

    def anyone_for(self, place):
        """Whether somebody queues for a movement, in whichever lane of its link."""
        link = self.nodes[place[0]].movements[place[1]].from_link
        return any(
            self.place_of(car) == place
            for lane, queue in self.lanes.items()
            if queue and lane[0] == link
            for car in queue
        )

    def queued(self):
        counts = defaultdict(int)
        for queue in self.lanes.values():
            for car in queue:
                counts[self.place_of(car)] += 1
        return counts

    def standing(self):
        """Queued cars without those at the front that have begun to move."""
        counts = self.queued()
        for lane, queue in self.lanes.items():
            if not self.wave or not queue or self.ready[lane] < self.now:
                continue
            moving, left = 0, 1
            for car in queue:
                i, j = self.place_of(car)
                if self.is_junction((i, j)):
                    break  # no controller sees it
                go_s = self.now - self.lights[i].go_from.get(j, self.now)
                if go_s <= 0 or moving == left:
                    break
                if moving == 0:
                    green_s = go_s + self.rules.startup_lost_s
                    left = int(self.wave * green_s - go_s / self.headway)
                    if left <= 0:
                        break
                moving += 1
                counts[i, j] -= 1
            self.started += moving
        return counts

    def room_on(self, link):
        return len(self.on_link[link]) < self.most_on[link]

    def enter(self, car):
        link = car.route[car.place]
        self.on_link[link].add(car)
        if self.time_on[link] == 0:
            self.reach_end(car)
        else:
            self.moving[link].append((self.now + self.time_on[link], car))

    def reach_end(self, car):
        if car.place == len(car.route) - 1:
            self.on_link[car.route[-1]].remove(car)
            car.arrived = self.now
            return
        lanes = self.lanes_of[*self.place_of(car), car.kind]
        self.lanes[min(lanes, key=lambda lane: len(self.lanes[lane]))].append(car)
        car.joined = self.now
        self.visits += not self.is_junction(self.place_of(car))

    @property
    def waiting_outside(self):
        return sum(map(len, self.outside.values()))

    def approaching(self, within):
        counts = defaultdict(int)
        for moving in self.moving.values():
            for due, car in moving:
                if due < self.now + within and car.place < len(car.route) - 1:
                    counts[self.place_of(car)] += 1
        return counts
