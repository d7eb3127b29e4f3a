"""Both memories of lanes in plain Python: what a phase gains, less what two decisions cost."""

from tests.differential.plain_factored import PlainFactored
from tests.differential.plain_lookahead import PlainLookahead

DEFAULTS = {
    "yields": True,
    "age": 0.025,
    "waves": "choice",
    "outside": True,
    "recall": True,
    "censored": True,
}
APART = {"curvature": 0.8, "queue_trust": 0.6, "trust": 1.0}


class PlainModel(PlainLookahead):
    """The model alone: whoever is owed green is counted by the values."""

    def least_cost(self, i, node, now, green):
        if i in self.moves.apart:
            alike, self.options = self.options, self.options | APART
            cost = self.least_cost_apart(i, node, now, green)
            self.options = alike
            return cost
        return min(self.pair_cost(node, now, then, green) for then in node.phases)


class PlainCombined(PlainFactored):
    """The whole decision; `table` has the values, `model.table` what the model misses."""

    def __init__(self, options=None):
        options = {**DEFAULTS, **(options or {})}
        self.weight = options.pop("weight", 1.0)
        super().__init__(options)
        self.model = PlainModel(options)

    def reset(self, context):
        super().reset(context)
        self.model.reset(context)
        self.model.groups, self.model.moves = self.groups, self.moves

    def look_at_all(self, seen):
        super().look_at_all(seen)
        self.model.seen = seen

    def choose(self, shown, green):
        # What is announced first comes from values alone.
        self.model.costs, self.foresees = {}, bool(green)
        return super().choose(shown, green)

    def merit(self, i, node, phase, green):
        merit = super().merit(i, node, phase, green)
        if not self.foresees:
            return merit
        return merit - self.weight * self.model.least_cost(i, node, phase, green)

    def learn(self, phases, seen):
        for i, node in enumerate(self.network.intersections):
            if self.asked is not None and seen.phase[i] == self.asked[i]:
                for group in self.groups[node.id]:
                    if self.learns_from(group):
                        self.model.learn_group(i, group)
        super().learn(phases, seen)
