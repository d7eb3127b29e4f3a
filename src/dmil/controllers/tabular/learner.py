"""What the tabular learners share: Algorithm 3's loop over decisions, for all agents at once."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar, NamedTuple

import numpy as np
import numpy.typing as npt

from dmil.arrays import Arrays, FloatArray, IntArray
from dmil.controllers.protocol import RunContext
from dmil.controllers.rules.phase_choice import PhaseChoice
from dmil.controllers.rules.shared_lanes import SharedLaneGuard
from dmil.controllers.tabular.agents import Agents, Prior, agents_of, classes_of
from dmil.controllers.tabular.announcements import Announcements
from dmil.controllers.tabular.choice import DRAWS
from dmil.controllers.tabular.meetings import NEWS, CentralReply, Meetings, Post
from dmil.controllers.tabular.settings import LearnerSettings
from dmil.errors import PolicyError
from dmil.memory import ABSENT, Merged, Rows, make_scratch
from dmil.network import RoadNetwork
from dmil.simulation import Observation
from dmil.symmetry import Classes, embedding

FIRST_CAPACITY = 64
COMMON = "common"


class Step(NamedTuple):
    """One decision of all agents, as the compiled kernels take it.

    Attributes
    ----------
    state: (agents, movements) int32
        Vehicles queued now, or with those that are announced.
    key_before, key: (agents, movements) int32
        Key at the last decision; key now, filled in place.
    action_before, action: (agents,) int32
        Last actions; next ones, filled in place.
    reward: (agents,) float64
        Reward of the last action.
    draws: (agents, 3) float64
        See `dmil.controllers.tabular.choice.DRAWS`.
    fallback: (agents,) int32
        What to do in an unseen state; −1: a random action.
    asks_nearest: bool
        Whether an unseen state does what the nearest class that is known does, if there is one.
    epsilon, learning_rate, discount: float
    learns: bool
        Whether there is a last action to learn from.
    news: (agents, 3) float64
        What was stored since the agents last met, added up in place; see `meetings.ROWS`.
    found_in: (4,) int64
        How often a state was found where, counted in place; see `TabularLearner.FOUND_IN`.
    """

    state: IntArray
    key_before: IntArray
    key: IntArray
    action_before: IntArray
    action: IntArray
    reward: FloatArray
    draws: FloatArray
    fallback: IntArray
    asks_nearest: bool
    epsilon: float
    learning_rate: float
    discount: float
    learns: bool
    news: FloatArray
    found_in: npt.NDArray[np.int64]


class TabularLearner(ABC):
    """One agent per intersection; what an agent remembers is its subclass's.

    Parameters
    ----------
    settings
        What all learners share.
    prior
        What to start from.
    """

    FOUND_IN: ClassVar[tuple[str, ...]]
    """Where a state may be found, "unseen" first: names of what kernels count."""
    settings: LearnerSettings
    epsilon: float
    """Chance of a random action at the next decision."""

    def __init__(self, settings: LearnerSettings, prior: Prior | None) -> None:
        self.settings = settings
        self._embedding = embedding(settings.embedding).changed(
            settings.scale_levels, settings.tolerance
        )
        self._prior = prior
        self._agents: Agents | None = None
        self._found_in = np.zeros(4, np.int64)
        # Per shape of intersection, how many leading rows all its agents have in common.
        self._common = np.zeros(0, np.int32)

    def reset(self, context: RunContext) -> None:
        """Get ready for a run; what was learned in an earlier run on the same shapes stays.

        Raises
        ------
        PolicyError
            If this controller, or the prior, learned on intersections of other shapes.
        """
        network = context.network
        agents = agents_of(network)
        is_new = self._agents is None
        if self._agents is not None and not self._fits(self._agents, agents):
            raise PolicyError(
                "it learned on intersections of other shapes",
                where=f"controller on network '{network.name}'",
                expected="the network that it learned on, or one of the same shapes in its order",
                mend="make a new controller for another network",
            )
        self._agents = agents
        self._classes = classes_of(network, self._embedding)
        self._phase_count = self._classes.phase_count[agents.shape]
        self._scratch = make_scratch(self._classes)
        self._rng, self.epsilon = context.rng, self.settings.epsilon
        self._meetings = Meetings(self.settings, len(agents.signatures))
        self._post = Post(self.settings.message_loss * self._communicates, context.rng)
        # What is under way at the end of a run is lost.
        self._answers: dict[int, CentralReply] = {}
        self._announcements = Announcements(context) if self.settings.announced else None
        self._guard = SharedLaneGuard(context, enabled=self.settings.guard)
        self._longest_queue = None
        if self.settings.unseen == "longest-queue":
            self._longest_queue = PhaseChoice(network, context.timing, hysteresis=0.0)
        count, places = len(network.intersections), self._classes.movement_image.shape[2]
        self._key, self._key_before = np.zeros((2, count, places), np.int32)
        self._action = np.zeros(count, np.int32)
        self._unknown = np.full(count, ABSENT, np.int32)
        self._news = np.zeros((count, NEWS))
        if is_new:
            check_prior(self._prior, self._classes, network)
            self._start(network, agents)

    def decide(self, observation: Observation, reward: FloatArray | None) -> IntArray:
        """Choose ε-greedily, learn from the last choice, meet the central unit when it is time."""
        settings, count = self.settings, self._action.size
        if self._answers:
            self._receive(observation.time_s)
        # Arrays as the compiled kernel reads them, whatever simulator and reward are.
        step = Step(
            state=np.ascontiguousarray(self._state(observation), np.int32),
            key_before=self._key,
            key=self._key_before,
            action_before=self._action,
            action=np.empty_like(self._action),
            reward=np.zeros(count) if reward is None else np.ascontiguousarray(reward, np.float64),
            draws=self._rng.random((count, DRAWS)),
            fallback=self._fallback(observation),
            asks_nearest=settings.unseen == "nearest",
            epsilon=self.epsilon,
            learning_rate=settings.learning_rate,
            discount=settings.discount,
            learns=settings.learning and reward is not None,
            news=self._news,
            found_in=self._found_in,
        )
        self._take(step)
        self._guard.overrule(observation, step.action)
        self._key_before, self._key, self._action = step.key_before, step.key, step.action
        self.epsilon *= settings.epsilon_decay
        if self._communicates:
            self._communicate(observation.time_s)
        return step.action

    def _state(self, observation: Observation) -> IntArray:
        """Return what is looked up and learned on: queues, or with those who will join them."""
        if self._announcements is None:
            return observation.queue_veh
        return self._announcements.queue_with_inflow(observation, observation.phase)

    @property
    def _communicates(self) -> bool:
        """Whether agents meet the central unit at all: whoever is frozen has nothing to tell."""
        return self.settings.communication and self.settings.learning

    def _communicate(self, time_s: int) -> None:
        """Let the agents of every shape send their memories, if they have reason to.

        While an answer is under way their next meeting waits.
        """
        post, delay_s = self._post, self.settings.communication_delay_s
        at_once = not (delay_s or self.settings.message_loss)
        for shape, members in enumerate(self.agents.members):
            if shape in self._answers:
                continue
            if not self._meetings.due(shape, time_s, self._news, members):
                continue
            self._news[members] = 0.0
            heard, reached = post.arrived(members)
            post.count(members.size, self._sent_bytes(members))
            if at_once:
                answer_bytes = self._meet(shape)
            elif heard.size:
                merged = self._merge(shape, heard)
                answer_bytes = merged.size_bytes
                self._answers[shape] = CentralReply(time_s + delay_s, merged, reached)
            else:
                continue
            post.count(members.size, members.size * answer_bytes)
        if not delay_s:
            self._receive(time_s)

    def _receive(self, time_s: int) -> None:
        """Take over the answers that have arrived."""
        for shape, answer in list(self._answers.items()):
            if answer.due_s <= time_s:
                del self._answers[shape]
                self._take_over(shape, answer.merged, answer.reached)

    def lookups(self) -> dict[str, int]:
        """Return how often the state at a decision was found where, since this was made."""
        return dict(zip(self.FOUND_IN, self._found_in.tolist(), strict=False))

    def _fallback(self, observation: Observation) -> IntArray:
        if self._longest_queue is None:
            return self._unknown
        return self._longest_queue.best(observation.queue_veh, observation.phase)

    @property
    def agents(self) -> Agents:
        """The agents that this controller controls."""
        assert self._agents is not None, "reset comes before anything else"
        return self._agents

    def _stored_once(self, sizes: IntArray) -> int:
        """Return how many rows there are, ``sizes`` for each agent, what is shared counted once."""
        stored = int(sizes.sum())
        if self.settings.communication:
            for members, common in zip(self.agents.members, self._common, strict=True):
                stored -= (members.size - 1) * int(common)
        return stored

    def _with_common(self, arrays: Arrays) -> Arrays:
        """Add to packed memories how many leading rows the agents of each shape have in common."""
        return {**arrays, COMMON: self._common.copy()}

    def _without_common(self, arrays: Arrays) -> tuple[Arrays, IntArray]:
        """Take apart what `_with_common` put together: PolicyError if it did not."""
        common = arrays.get(COMMON)
        if common is None or common.shape != self._common.shape or common.dtype != np.int32:
            raise PolicyError(
                f"array '{COMMON}' is missing or not what it should be",
                where="saved memory",
                expected=f"one whole number for each of the {self._common.size} shapes, int32",
                mend="train it again with this version of dmil",
            )
        rest = {name: array for name, array in arrays.items() if name != COMMON}
        return rest, common.astype(np.int32)

    def _check_common(self, common: IntArray, rows: Rows) -> None:
        """Check that the agents of each shape have so many leading keys in common, or refuse it."""
        for members, count in zip(self.agents.members, common.tolist(), strict=True):
            keys = rows.keys[members, : max(count, 0)]
            if not 0 <= count <= rows.size[members].min() or (keys != keys[:1]).any():
                raise PolicyError(
                    f"array '{COMMON}' says {count} rows, which the agents do not have in common",
                    where="saved memory",
                    mend="train it again",
                )

    def _fits(self, known: Agents, agents: Agents) -> bool:
        return known.signatures == agents.signatures and np.array_equal(known.shape, agents.shape)

    @abstractmethod
    def arrays(self) -> Arrays:
        """Return all that was learned as flat arrays, as `restore` takes them."""

    @abstractmethod
    def restore(self, arrays: Arrays) -> None:
        """Replace all that was learned; call after `reset`."""

    @abstractmethod
    def _start(self, network: RoadNetwork, agents: Agents) -> None:
        """Make the memories to start from."""

    @abstractmethod
    def _take(self, step: Step) -> None:
        """Take one decision: choose, and learn from the last choice."""

    @abstractmethod
    def _sent_bytes(self, members: IntArray) -> int:
        """Return the bytes of what some agents send to the central unit, all together."""

    @abstractmethod
    def _meet(self, shape: int) -> int:
        """Give all agents of a shape the average of their memories; return the bytes of it."""

    @abstractmethod
    def _merge(self, shape: int, heard: IntArray) -> Merged:
        """Return the average of the memories of some agents of a shape."""

    @abstractmethod
    def _take_over(self, shape: int, merged: Merged, reached: IntArray) -> None:
        """Give some agents of a shape what `_merge` returned; what it lacks they keep."""


def check_prior(prior: Prior | None, classes: Classes, network: RoadNetwork) -> None:
    """Raise an error if a prior cannot have been learned on a network (ours).

    Raises
    ------
    PolicyError
        If it has another number of shapes, movements or phases.
    """
    if prior is None:
        return
    shapes, _, places = classes.movement_image.shape
    fitting = (shapes, places // classes.parts, classes.phase_image.shape[2])
    found = (*prior.table.rows.keys.shape[::2], prior.table.value.shape[2])
    if found != fitting:
        raise PolicyError(
            "a Q-table of {} shapes with up to {} movements and {} phases".format(*found),
            where=f"prior of a controller on network '{network.name}'",
            expected="{}, {} and {}".format(*fitting),
            mend="train the prior on the same network",
        )
    if prior.table.rows.tolerance:
        raise PolicyError(
            "a Q-table of classes of states",
            where="prior of a controller",
            expected="an exact one, which can be read into any embedding",
            mend="train the prior with the embedding 'exact'",
        )
