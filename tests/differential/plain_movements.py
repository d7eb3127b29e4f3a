"""What tells movements apart, in plain Python: who yields, and who has waited for long."""

MOST_OWED, LONG_QUEUE, STEP = 4.0, 4.0, 0.05


class PlainMovements:
    """Ages and averages of all movements, and what phases do to them."""

    def __init__(self, network, timing, flow_veh, after_switch, options, all_stop):
        self.network, self.options, self.after_switch = network, options, after_switch
        self.interval_s, self.flow_veh = timing.decision_interval_s, flow_veh
        self.all_stop = all_stop
        keys = [
            (i, j) for i, n in enumerate(network.intersections) for j in range(len(n.movements))
        ]
        self.age, self.mean, self.goes = ({key: 0.0 for key in keys} for _ in range(3))
        self.usual = [0.0] * len(network.intersections)
        self.owed, self.apart = {}, []

    def find_apart(self, groups):
        """Note at which intersections movements are told apart, given the groups of each."""
        for i, node in enumerate(self.network.intersections):
            partly = any(
                0 < len(phase.intersection(group.members)) < len(group.members)
                for phase in node.phases
                for group in groups[node.id]
            )
            foes = self.options["yields"] and any(
                map(any, ((k + 1 for k in each) for each in node.gives_way))
            )
            if self.all_stop[i] or foes or (self.options["age"] and partly):
                self.apart.append(i)

    def look(self, seen, asked, groups):
        """Move ages and averages on, and find who is owed green."""
        for i, node in enumerate(self.network.intersections):
            signalled = [j for j in range(len(node.movements)) if j not in node.unsignalled]
            for j in range(len(node.movements)):
                now = int(seen.queue_veh[i, j]) + int(seen.approaching_veh[i, j])
                self.mean[i, j] += STEP * (now - self.mean[i, j])
            green = node.phases[seen.phase[i]] if seen.phase[i] >= 0 else frozenset()
            for j in signalled if asked is not None else ():
                went = 0.0
                if j in green:
                    went = self.goes[i, j] if seen.phase[i] == asked[i] else 1.0
                    if self.age[i, j] > 0:
                        self.usual[i] += STEP * (self.age[i, j] - self.usual[i])
                waited = (self.age[i, j] + self.interval_s) * (1 - went)
                self.age[i, j] = waited if seen.queue_veh[i, j] > 0 else 0.0
            lanes = sum(group.count for group in groups[node.id])
            queued = sum(float(group.queue) * group.count for group in groups[node.id])
            calm = max(0.0, 1 - queued / (LONG_QUEUE * max(lanes, 1)))
            for j in signalled:
                late = max(0.0, self.age[i, j] - self.usual[i])
                self.owed[i, j] = calm * min(self.options["age"] * late, MOST_OWED)

    def vehicles(self, i, seen, groups):
        """Return X of all movements of an intersection."""
        node = self.network.intersections[i]
        sees = self.options["approaching"]
        found = {
            j: float(seen.queue_veh[i, j] + seen.approaching_veh[i, j] * sees)
            for j in range(len(node.movements))
        }
        for group in groups[node.id]:
            more = float(group.queue + group.expected) * group.count
            more -= sum(found[j] for j in group.members)
            share = self.shares(i, group)
            for j in group.members:
                found[j] += more * share[j]
        return found

    def shares(self, i, group):
        weights = {j: self.mean[i, j] + 0.05 for j in group.members}
        return {j: weight / sum(weights.values()) for j, weight in weights.items()}

    def green(self, i, j, phase, before):
        """Return c of a movement that has green in a phase; before it another one or None."""
        keeps = before is not None and j in before and (phase == before or not self.all_stop[i])
        return 1.0 if keeps else self.after_switch

    def going(self, i, phase, before, vehicles):
        """Return y of all movements."""
        node = self.network.intersections[i]
        found = {}
        for j in range(len(node.movements)):
            found[j] = 1.0 if j in phase | node.unsignalled else 0.0
            if not found[j] or not self.options["yields"] or not node.gives_way:
                continue
            for k in node.gives_way[j]:
                if k in phase | node.unsignalled:
                    green = 1.0
                    if k in phase and before is not None:
                        green = self.green(i, k, phase, before)
                    full = self.flow_veh * max(1, len(node.movements[k].lanes)) * green
                    found[j] = min(found[j], 1 - min(1.0, vehicles[k] / max(full, 1e-9)))
        return found

    def treat(self, i, group, phase, before, vehicles):
        """Return φ and c of a group."""
        going = self.going(i, phase, before, vehicles)
        lit = {j: self.green(i, j, phase, before) for j in group.members if j in phase}
        total = sum(vehicles[j] for j in group.members)
        served = sum(vehicles[j] * going[j] for j in lit)
        part = served / total if total > 1e-5 else len(lit) / len(group.members)
        if served > 1e-5:
            return part, sum(vehicles[j] * going[j] * lit[j] for j in lit) / served
        return part, sum(lit.values()) / len(lit) if lit else 0.0

    def owed_in(self, i, phase, before, vehicles):
        """Return what a phase counts more for those who waited for long."""
        if not self.options["age"]:
            return 0.0
        going = self.going(i, phase, before, vehicles)
        return sum(self.owed[i, j] * going[j] * self.green(i, j, phase, before) for j in phase)

    def remember(self, phases, shown, vehicles):
        """Keep y under the phases chosen; ``vehicles`` has X of the intersections told apart."""
        for i, node in enumerate(self.network.intersections):
            phase = node.phases[phases[i]]
            before = node.phases[shown[i]] if shown[i] >= 0 else None
            going = dict.fromkeys(phase | node.unsignalled, 1.0)
            if i in self.apart:
                going = self.going(i, phase, before, vehicles[i])
            for j in range(len(node.movements)):
                self.goes[i, j] = going.get(j, 0.0)
