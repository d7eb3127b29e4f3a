"""Sections on what the agent learns, and what becomes of it in the memories."""

from __future__ import annotations

from math import isnan

import numpy as np

from dmil.memory import ABSENT, Found
from dmil.reports.one_decision.story import SIDES, Story, by_side, decimal, plain, subtracted, table
from dmil.reports.one_decision.trace import StagedRow


def rewarded(story: Story) -> str:
    """Tell the reward of the last action; the reward is "diffusion"."""
    decision = story.decision
    growth = decision.state - decision.last_state
    squares = [int(d) * abs(int(d)) for d in growth if d]
    terms = "".join(f" {'−' if square < 0 else '+'} {abs(square)}" for square in squares)
    rows = (
        ("queued then", *by_side(decision.last_state)),
        ("queued now", *by_side(decision.state)),
        ("growth d", *by_side(growth)),
    )
    return f"""## The reward of the last action

The agent also learns, from its last action. At t = {decision.last.observation.time_s} s it chose
{story.phase(decision.last_action)}, and this came of it (right, straight, left):

{table(("", *SIDES), rows)}

The reward is −mean(sign(d)·d²) over the {growth.size} movements (paper, §VI-A, "Diffusion"). The
sum is {terms.removeprefix(" + ").strip() or 0} = {plain(sum(squares))}, so
R = −{subtracted(sum(squares), 0)}/{growth.size} = {decimal(decision.reward)}."""


def updated(story: Story) -> str:
    """Tell the SARSA update."""
    decision, settings = story.decision, story.trace.settings
    target = decision.reward + settings.discount * decision.following
    rate, discount = plain(settings.learning_rate), plain(settings.discount)
    old, following = decimal(decision.known), decimal(decision.following)
    return f"""## The SARSA update

Q(S, A) ← Q(S, A) + α·[R + γ·Q(S′, A′) − Q(S, A)] (paper, §IV-C), with α = {rate} and γ =
{discount}. S and A are the last state and action, S′ and A′ those of now. A Q is read from
short-term memory if the action was tried there, else from long-term memory if it is the action
stored there, else it is 0.

- Q(S, A) = {old}, {_source(story, decision.last_found, decision.last_action)}
- Q(S′, A′) = {following}, {_source(story, decision.found, decision.action)}
- target: R + γ·Q(S′, A′) = {decimal(decision.reward)} + {discount}·{following} = {decimal(target)}
- new Q(S, A): {old} + {rate}·({decimal(target)} − {subtracted(decision.known)}) = \
**{decimal(decision.learned)}**"""


def _source(story: Story, found: Found, action: int) -> str:
    memory, agent, turned = story.decision.moment.memory, story.agent, story.trace.turned
    short, long = found.short_row, found.long_row
    equivalent = turned(agent, found.short_variant, action)
    if short != ABSENT and memory.short.tried[agent, short, equivalent]:
        return f"from short-term memory, row {short}"
    equivalent = turned(agent, found.long_variant, action)
    if long != ABSENT and memory.long.action[agent, long] == equivalent:
        return f"from long-term memory, row {long}"
    return "because neither memory has one"


def inserted(story: Story) -> str:
    """Tell where the new Q goes."""
    decision, agent = story.decision, story.agent
    row, variant = decision.last_found.short_row, decision.last_found.short_variant
    short, action = decision.moment.memory.short, decision.last_action
    size, capacity = int(short.rows.size[agent]), story.trace.settings.short_capacity
    if row == ABSENT:
        text = f"""Short-term memory does not have its class, so the key becomes row {size}, with
            {decimal(decision.learned)} as Q of {story.phase(action)}."""
    else:
        stored = story.trace.turned(agent, variant, action)
        phase, known = story.phase(stored), decimal(short.value[agent, row, stored])
        was = f"it was {known}" if short.tried[agent, row, stored] else "it was not tried before"
        text = f"Its class is row {row}, with the key {story.key(short.rows.keys[agent, row])}. "
        if variant:
            side = story.east_becomes(variant)
            text += f"Turned along (East becomes {side}), the action is {phase}. "
        text += f"Q of {phase} there becomes {decimal(decision.learned)}; {was}."
    return f"""## Into short-term memory

The new Q is inserted for the last state (Algorithm 1), whose key is
{story.key(decision.last_key)}. {text} Short-term memory now has {size + (row == ABSENT)} of at
most {capacity} classes;
{"that is full, and it is staged" if decision.stages else "it is staged when it is full"}."""


def staged(story: Story) -> str:
    """Tell a staging."""
    decision, settings = story.staging, story.trace.settings
    rows = story.trace.staging(decision)
    shown = [
        (story.key(row.key), story.phase(row.action), decimal(row.value), *_fate(story, row))
        for row in rows
    ]
    before, after = decision.moment.memory.long, decision.after.long
    sizes = f"{before.rows.size[decision.agent]} to {after.rows.size[decision.agent]}"
    return f"""## A staging

At t = {decision.moment.observation.time_s} s short-term memory of intersection
{story.place(decision.agent)} holds {len(rows)} classes and is full. The part κ =
{plain(settings.staged_ratio)} of them with the highest Q goes to long-term memory, each with its
best action (Algorithms 1 and 2). A class that long-term memory does not know is new there. One
that it knows is replaced if the new Q is significantly better, above Q +
{plain(settings.significance)}·|Q| of the old one, and refused otherwise. Then short-term memory
is emptied. Long-term memory goes from {sizes} classes.

{table(("key", "best action", "Q", "old Q", "needed: above", "outcome"), shown)}"""


def _fate(story: Story, row: StagedRow) -> tuple[str, str, str]:
    if isnan(row.known):
        return "", "", row.outcome
    bar = row.known + story.trace.settings.significance * abs(row.known)
    return decimal(row.known), decimal(bar), row.outcome


def met(story: Story) -> str:
    """Tell a meeting with the central unit, for one class on which the agents differ."""
    trace = story.trace
    before, after, common = trace.meeting()
    actions, values = before.action[:, :common], before.value[:, :common]

    def differences(row: int) -> tuple[int, int]:
        return len(set(actions[:, row].tolist())), len(set(values[:, row].tolist()))

    row = max(range(common), key=differences)
    votes = [
        (story.place(agent), story.phase(actions[agent, row]), decimal(values[agent, row]))
        for agent in range(len(actions))
    ]
    means = []
    for action in sorted(set(actions[:, row].tolist())):
        voted = values[actions[:, row] == action, row]
        terms = " + ".join(decimal(value) for value in voted).replace("+ −", "− ")
        mean = decimal(float(np.mean(voted)))
        means.append(f"- {story.phase(action)}: ({terms})/{voted.size} = {mean}")
    sizes, listed = before.rows.size.tolist(), "\n".join(means)
    return f"""## A meeting with the central unit

The agents of this run learned alone. With `communication` they meet the central unit every
{trace.settings.communication_period_s} s: it puts their long-term memories together, averages Q
for each class and action, keeps the best action of each class, and gives the result to all
(paper, §IV-B). If they met at t = {trace.moments[-1].observation.time_s} s, memories of
{min(sizes)} to {max(sizes)} classes would become one of {after.rows.size[0]}. For example row
{row}, with the key {story.key(before.rows.keys[0, row])}:

{table(("intersection", "action", "Q"), votes)}

The means:

{listed}

So every agent then has {story.phase(int(after.action[0, row]))} with Q =
{decimal(after.value[0, row])} for this class."""
