"""One decision of dual memory, compiled: Algorithm 3 for all agents."""

from __future__ import annotations

from dmil.compilation import kernel
from dmil.controllers.protocol import LongArray
from dmil.controllers.tabular.choice import explores, uniform_action, unseen_action
from dmil.controllers.tabular.learner import Step
from dmil.controllers.tabular.meetings import CHANGE, ROWS, STAGED
from dmil.memory import (
    ABSENT,
    DualMemory,
    Scratch,
    find_again,
    find_both,
    note_found,
    recall,
    recall_nearest,
    recalled_value,
    remember,
)
from dmil.symmetry import Classes, embed


@kernel
def decide_dual_memory(
    classes: Classes, memory: DualMemory, step: Step, found_before: LongArray, scratch: Scratch
) -> None:
    """Choose the next actions of all agents and remember Q of the last ones (Algorithm 3).

    Parameters
    ----------
    classes, memory
        Equivalence classes, and the memories of all agents.
    step
        See `Step`.
    found_before: (agents, 6) int64
        Where ``key_before`` was found, then where ``key`` was; see `dmil.memory.note_found`.
    scratch
        Working space.
    """
    short_changes, long_changes = memory.short.rows.changes, memory.long.rows.changes
    for agent in range(step.state.shape[0]):
        shape = classes.shape[agent]
        key, key_before = step.key[agent], step.key_before[agent]
        draws = step.draws[agent]
        embed(classes, step.state[agent], key)
        found = find_both(memory, classes, agent, shape, key, scratch)
        found_with = short_changes[agent], long_changes[agent]
        step.found_in[(found.short_row != ABSENT) + 2 * (found.long_row != ABSENT)] += 1
        count = classes.phase_count[shape]
        if explores(draws, step.epsilon):
            action = uniform_action(draws[1], count)
        else:
            action = recall(memory, classes, agent, shape, found)
            if action == ABSENT and step.asks_nearest:
                action = recall_nearest(memory, classes, agent, shape, key, scratch)
            if action == ABSENT:
                action = unseen_action(step.fallback[agent], draws[1], count)
        step.action[agent] = action
        if not step.learns:
            note_found(found, found_with[0], found_with[1], found_before[agent])
            continue
        following = recalled_value(memory, classes, agent, shape, found, action)
        last = step.action_before[agent]
        again = find_again(memory, classes, agent, shape, key_before, found_before[agent], scratch)
        note_found(found, found_with[0], found_with[1], found_before[agent])
        before = recalled_value(memory, classes, agent, shape, again, last)
        error = step.reward[agent] + step.discount * following - before
        value = before + step.learning_rate * error
        remember(memory, classes, agent, shape, key_before, again, last, value, scratch)
        step.news[agent, ROWS] += again.short_row == ABSENT
        step.news[agent, CHANGE] += abs(value - before)
        # Staging is what empties short-term memory.
        step.news[agent, STAGED] += memory.short.rows.size[agent] == 0
