"""Sections on what the agent sees, what it knows of it, and what it chooses."""

from __future__ import annotations

import numpy as np

from dmil.reports.one_decision.story import (
    SIDES,
    TURNS,
    IntArray,
    Story,
    decimal,
    line,
    plain,
    table,
)
from dmil.reports.one_decision.trace import Answer


def seen(story: Story) -> str:
    """Tell the state and the actions."""
    state = story.decision.state
    rows = list(zip(SIDES, *state.reshape(len(SIDES), len(TURNS)).T.tolist(), strict=True))
    return f"""## What the agent sees

The state is the number of vehicles queued for each movement, {state.size} numbers:

{table(("from the", *TURNS), rows)}

In one line, with right, straight and left for East, North, West and South: {line(state)}.

The agent has {len(story.phases)} actions, the phases of its signals:
{", ".join(story.all_phases())}. F means straight on, L left; right turns may always go."""


def turned(story: Story) -> str:
    """Tell the symmetric images of the state, with the phases turned along."""
    trace, state, agent = story.trace, story.decision.state, story.agent
    head = "## The same state, turned\n\n"
    if not trace.embedding.rotations:
        return head + "These classes do not use symmetries."
    shape = trace.classes.shape[agent]
    images, phases = [], []
    for variant in range(trace.classes.variant_count[shape]):
        image = np.empty_like(state)
        image[trace.classes.movement_image[shape, variant, : state.size]] = state
        side = story.east_becomes(variant)
        images.append((side, line(image)))
        actions = [trace.turned(agent, variant, action) for action in range(len(story.phases))]
        phases.append((side, *map(story.phase, actions)))
    return f"""{head}Turn the intersection, and it is the same intersection again: what came from
the East now comes from the North, say, and the phase that served it is another phase. So all
images of a state may share one class, if the actions are turned along (paper, §IV-A). There are
{len(images)} images:

{table(("East becomes", "queues"), images)}

The phases turn along:

{table(("East becomes", *story.all_phases()), phases)}"""


def keyed(story: Story) -> str:
    """Tell how the state becomes a key, and when two keys are of one class."""
    kind, decision = story.trace.embedding, story.decision
    text = "## The key\n\n"
    if kind.scale_levels:
        levels, largest = kind.scale_levels, max(1, int(decision.state.max()))
        steps = [
            f"- x = {count}: ⌊{levels}·{count}/{largest} + ½⌋ = "
            f"⌊{decimal(levels * count / largest + 0.5, 2)}⌋ = "
            f"{(2 * levels * count + largest) // (2 * largest)}"
            for count in sorted({int(count) for count in decision.state if count > 0})
        ]
        listed = "\n".join(steps)
        text += f"""Queues in the same proportions call for the same phase. So the counts x are
scaled to y = ⌊B·x/max(x) + ½⌋, with B = {levels} and here max(x) = {largest}:

{listed}

"""
    if kind.cell_width > 1:
        text += f"Each number y becomes ⌊(y + {kind.cell_offset}) / {kind.cell_width}⌋.\n\n"
    near = f"nowhere more than {kind.tolerance} apart" if kind.tolerance else "equal"
    if len(story.parts(decision.key)) > 1:
        near += ", as they are or scaled"
    return f"""{text}The key is {story.key(decision.key)}.

Two keys belong to one class if {"an image of one" if kind.rotations else "one"} and the other are
{near}. The key that was stored first stands for its class. If more than one stored key matches,
the nearest counts (least sum of differences), of equally near ones the oldest."""


def known(story: Story) -> str:
    """Tell what either memory says about the state."""
    decision, memory, agent = story.decision, story.decision.moment.memory, story.agent
    long, short = decision.long, decision.short
    absent = "It does not know this one."
    in_long, in_short = absent, absent
    if long is not None:
        in_long = f"""{_match(story, long, memory.long.rows.keys[agent, long.row])} The action
there is {story.phase(long.stored)}, with Q = {decimal(long.value)}. For the state as it is, that is
            {story.phase(long.action)}."""
    if short is not None:
        rows = []
        for stored in np.flatnonzero(memory.short.tried[agent, short.row]).tolist():
            action = story.trace.turned_back(agent, short.variant, stored)
            value = decimal(memory.short.value[agent, short.row, stored])
            rows.append((story.phase(stored), story.phase(action), value))
        in_short = f"""{_match(story, short, memory.short.rows.keys[agent, short.row])} What was
tried there:

{table(("action there", "for the state as it is", "Q"), rows)}"""
    return f"""## What the memories know

**Long-term memory** keeps one action and its Q for each class. {in_long}

**Short-term memory** keeps a Q for every action that was tried in a class. {in_short}"""


def _match(story: Story, answer: Answer, key: IntArray) -> str:
    image = story.trace.images_of(story.agent, story.decision.key)[answer.variant]
    gaps = []
    for (name, theirs), (_, ours) in zip(story.parts(key), story.parts(image), strict=True):
        apart = abs(theirs - ours)
        gap = f"largest difference {apart.max()}, sum of differences {apart.sum()}"
        gaps.append(f"{name}: {gap}" if name else gap)
    side = story.east_becomes(answer.variant)
    how = f"our key turned (East becomes {side})" if answer.variant else "our key"
    return f"""Its row {answer.row} matches: the key there is {story.key(key)}, and {how} is
        {story.key(image)} ({"; ".join(gaps)})."""


def chosen(story: Story) -> str:
    """Tell which action is chosen, and why."""
    decision, settings = story.decision, story.trace.settings
    draw, epsilon = decision.moment.draws[story.agent][0], plain(settings.epsilon)
    text = f"## The choice\n\nWith chance ε = {epsilon} the agent tries a random action. "
    if decision.explored:
        text += f"It draws {decimal(draw)}, below ε, so the action is random. "
    elif decision.long and decision.short:
        old, new, part = decision.long.value, decision.short.value, plain(settings.significance)
        bar = old + settings.significance * abs(old)
        text += f"""It draws {decimal(draw)}, not below ε, so it asks its memories.

Long-term memory has priority, unless short-term memory's best Q is significantly higher (paper,
§IV-B). We read that as above Q + {part}·|Q| of long-term memory: {decimal(old)} +
{part}·{decimal(abs(old))} = {decimal(bar)}. Short-term memory's best is {decimal(new)}, which is
{"" if new > bar else "not "}higher: {"short" if new > bar else "long"}-term memory wins. """
    else:
        text += (
            f"It draws {decimal(draw)}, not below ε, so it does what it remembers, if anything. "
        )
    return f"{text}The agent chooses **{story.phase(decision.action)}**."
