"""Dual-memory agents watched at every decision: what they saw, knew, chose and learned.

Every number is read from the real memories by the functions that the agents themselves use.
"""

from __future__ import annotations

from copy import deepcopy
from dataclasses import dataclass

import numpy as np

from dmil.controllers import Prior
from dmil.controllers.tabular.agents import agents_of, classes_of
from dmil.controllers.tabular.choice import explores
from dmil.controllers.tabular.dual_memory import DualMemoryController
from dmil.controllers.tabular.settings import DualMemorySettings
from dmil.memory import (
    ABSENT,
    BestTable,
    DualMemory,
    Found,
    Scratch,
    average_best,
    best_table_with_room,
    best_tried,
    consolidate,
    find_both,
    look_up,
    make_scratch,
    recall,
    recalled_value,
    remember,
)
from dmil.reports.one_decision.watch import IntArray, Moment, Watch
from dmil.rewards import make_reward
from dmil.scenarios import Scenario
from dmil.simulation import QueueSimulator
from dmil.symmetry import Classes, embed, embedding, vary
from dmil.theory import staged_rows
from dmil.training import evaluate, train_prior, vehicles_of_seed


@dataclass(frozen=True, slots=True)
class Answer:
    """What one memory says about a state.

    Attributes
    ----------
    row, variant: int
        Row of the state's class, and the symmetry that carries the state's key to the row's key.
    stored, action, value
        Its best action, as it is stored and for the state as it is, and its Q.
    """

    row: int
    variant: int
    stored: int
    action: int
    value: float


@dataclass(frozen=True, slots=True)
class Decision:
    """One decision of one agent, and what it learned there from its last one.

    Attributes
    ----------
    moment, last, after
        This decision and the one before, of all agents; memories after this decision.
    key, last_key: (places,) int32
    long, short
        What either memory says about the state; None if its class is not there.
    recalled: int
        Action that the memories recall; −1 if neither knows the class.
    found, last_found
        Where the classes of this and of the last state are.
    known, following, learned
        Q of the last state and action before; Q of this state and action; the new Q of the last.
    """

    moment: Moment
    last: Moment
    after: DualMemory
    agent: int
    key: IntArray
    last_key: IntArray
    long: Answer | None
    short: Answer | None
    explored: bool
    recalled: int
    found: Found
    last_found: Found
    known: float
    following: float
    learned: float

    @property
    def state(self) -> IntArray:
        """Vehicles queued, (movements,) int32."""
        state: IntArray = self.moment.observation.queue_veh[self.agent]
        return state

    @property
    def last_state(self) -> IntArray:
        """The same one decision earlier."""
        state: IntArray = self.last.observation.queue_veh[self.agent]
        return state

    @property
    def stages(self) -> bool:
        """Whether short-term memory was staged, and so is empty now."""
        return int(self.after.short.rows.size[self.agent]) == 0

    @property
    def reward(self) -> float:
        """Reward of the last action."""
        assert self.moment.reward is not None
        return float(self.moment.reward[self.agent])

    @property
    def action(self) -> int:
        """What was chosen."""
        return int(self.moment.action[self.agent])

    @property
    def last_action(self) -> int:
        """What was chosen one decision earlier."""
        return int(self.last.action[self.agent])


@dataclass(frozen=True, slots=True)
class StagedRow:
    """A row of a short-term memory that is full, and what becomes of it.

    Attributes
    ----------
    key: (places,) int32
    action, value
        Best action that was tried, and its Q.
    outcome: str
        "forgotten", or if it is staged "new", "replaces" or "refused".
    known: float
        Q that long-term memory had for the class; NaN if it had none or was not asked.
    """

    key: IntArray
    action: int
    value: float
    outcome: str
    known: float


class Trace:
    """A run of dual-memory agents that start from a trained table, decision by decision.

    The scenario says for how long both training and run last.
    """

    def __init__(
        self, scenario: Scenario, reward: str, seed: int, settings: DualMemorySettings
    ) -> None:
        self.scenario, self.settings = scenario, settings
        self.embedding = embedding(settings.embedding)
        rewarded = make_reward(reward)
        self.prior: Prior = train_prior(scenario, rewarded, seed)
        agents = DualMemoryController(settings, prior=self.prior)
        watch = Watch(agents)
        vehicles = vehicles_of_seed(scenario, seed)
        evaluate(QueueSimulator(scenario), watch, vehicles, rewarded, seed)
        self.moments = watch.moments
        self.classes: Classes = classes_of(scenario.network, self.embedding)
        self.scratch: Scratch = make_scratch(self.classes)

    def key_of(self, state: IntArray) -> IntArray:
        """Return the key, (places,) int32, of a state, (movements,) int32."""
        key = np.zeros(self.moments[0].memory.long.rows.keys.shape[2], np.int32)
        embed(self.classes, state, key)
        return key

    def images_of(self, agent: int, key: IntArray) -> IntArray:
        """Return a key under every symmetry of an agent's intersection, (images, places) int32."""
        count = vary(self.classes, self.classes.shape[agent], key, self.scratch.variants)
        return self.scratch.variants[:count].copy()

    def decisions(self) -> list[Decision]:
        """Return all decisions of all agents but the first and the last of the run, in order."""
        threes = zip(self.moments[:-2], self.moments[1:-1], self.moments[2:], strict=True)
        agents = range(len(self.scenario.network.intersections))
        return [self._decision(*three, agent) for three in threes for agent in agents]

    def _decision(self, last: Moment, moment: Moment, following: Moment, agent: int) -> Decision:
        shape, memory = self.classes.shape[agent], moment.memory
        key = self.key_of(moment.observation.queue_veh[agent])
        last_key = self.key_of(last.observation.queue_veh[agent])
        here = (memory, self.classes, agent, shape)
        found = find_both(*here, key, self.scratch)
        last_found = find_both(*here, last_key, self.scratch)
        known = recalled_value(*here, last_found, last.action[agent])
        follows = recalled_value(*here, found, moment.action[agent])
        assert moment.reward is not None, "nothing is learned at the first decision"
        target = moment.reward[agent] + self.settings.discount * follows
        # A row that is absent has number −1: what is read there is not used.
        best = best_tried(memory.short, agent, found.short_row, self._phases(agent))
        short = (found.short_row, found.short_variant, best)
        long = (found.long_row, found.long_variant, int(memory.long.action[agent, found.long_row]))
        return Decision(
            moment=moment,
            last=last,
            after=following.memory,
            agent=agent,
            key=key,
            last_key=last_key,
            long=self._answer(agent, *long, memory.long.value[agent, found.long_row]),
            short=self._answer(agent, *short, memory.short.value[agent, found.short_row, best]),
            explored=explores(moment.draws[agent], self.settings.epsilon),
            recalled=int(recall(*here, found)),
            found=found,
            last_found=last_found,
            known=known,
            following=follows,
            learned=known + self.settings.learning_rate * (target - known),
        )

    def _answer(
        self, agent: int, row: int, variant: int, stored: int, value: float
    ) -> Answer | None:
        if row == ABSENT:
            return None
        return Answer(row, variant, stored, self.turned_back(agent, variant, stored), float(value))

    def _phases(self, agent: int) -> int:
        return int(self.classes.phase_count[self.classes.shape[agent]])

    def turned(self, agent: int, variant: int, action: int) -> int:
        """Return an action under a symmetry of the agent's intersection."""
        return int(self.classes.phase_image[self.classes.shape[agent], variant, action])

    def turned_back(self, agent: int, variant: int, action: int) -> int:
        """Return the action whose image under a symmetry is the one given."""
        return int(self.classes.phase_preimage[self.classes.shape[agent], variant, action])

    def before_staging(self, decision: Decision) -> DualMemory:
        """Return a copy of the memories with what a decision learned, staged by no rule."""
        memory = deepcopy(decision.moment.memory)
        agent, shape = decision.agent, self.classes.shape[decision.agent]
        capacity = memory.short_capacity
        memory = memory._replace(
            long=best_table_with_room(memory.long, capacity),
            short_capacity=capacity + 1,
            stage_period=0,
        )
        learned = (decision.last_key, decision.last_found, decision.last_action, decision.learned)
        remember(memory, self.classes, agent, shape, *learned, self.scratch)
        return memory

    def staging(self, decision: Decision) -> list[StagedRow]:
        """Return the rows of a short-term memory that a decision stages, the best first."""
        agent, shape = decision.agent, self.classes.shape[decision.agent]
        full = self.before_staging(decision)
        short, size = full.short, int(full.short.rows.size[agent])
        best = [best_tried(short, agent, row, self._phases(agent)) for row in range(size)]
        value = [float(short.value[agent, row, best[row]]) for row in range(size)]
        wanted = staged_rows(size, self.settings.staged_ratio)
        rows = []
        for rank, row in enumerate(sorted(range(size), key=lambda row: -value[row])):
            key, outcome, known = short.rows.keys[agent, row].copy(), "forgotten", float("nan")
            if rank < wanted:
                outcome, known = self._consolidated(full, agent, shape, key, best[row], value[row])
            rows.append(StagedRow(key, best[row], value[row], outcome, known))
        return rows

    def _consolidated(
        self, memory: DualMemory, agent: int, shape: int, key: IntArray, action: int, value: float
    ) -> tuple[str, float]:
        """Put one row into the long-term memory; return what that did, and the Q known before."""
        long, classes, scratch = memory.long, self.classes, self.scratch
        row, _ = look_up(long.rows, classes, agent, shape, key, scratch)
        known = float("nan") if row == ABSENT else float(long.value[agent, row])
        staged = (agent, shape, key, action, value, memory.significance)
        consolidate(long, memory.admission, classes, *staged, scratch)
        if row == ABSENT:
            return "new", known
        return ("replaces" if float(long.value[agent, row]) != known else "refused"), known

    def meeting(self) -> tuple[BestTable, BestTable, int]:
        """Let the agents of the first shape meet the central unit after their last decision.

        Returns
        -------
        before, after: BestTable
            Long-term memories before and after.
        common: int
            How many leading rows have the same keys for all.
        """
        before = self.moments[-1].memory.long
        members = agents_of(self.scenario.network).members[0]
        least = int(before.rows.size[members].min())
        keys = before.rows.keys[members, :least]
        differ = np.flatnonzero((keys != keys[:1]).any(axis=(0, 2)))
        common = int(differ[0]) if differ.size else least
        more = int((before.rows.size[members] - common).sum())
        after = best_table_with_room(deepcopy(before), more)
        average_best(after, self.classes, members, common, self.scratch)
        return before, after, common
