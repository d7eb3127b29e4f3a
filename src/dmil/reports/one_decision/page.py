"""The page: which decision is shown, and its sections in order."""

from __future__ import annotations

from dmil.controllers.tabular.settings import DualMemorySettings
from dmil.memory import ABSENT
from dmil.reports.one_decision import knowing, learning
from dmil.reports.one_decision.story import Story, plain, wrapped
from dmil.reports.one_decision.trace import Decision, Trace
from dmil.scenarios import scenario

SCENARIO, HORIZON_S, REWARD, SEED = "grid:3x3", 600, "diffusion", 0
"""What the page shows. Its text explains grids and this reward; the rest may be changed."""

SECTIONS = (
    knowing.seen,
    knowing.turned,
    knowing.keyed,
    knowing.known,
    knowing.chosen,
    learning.rewarded,
    learning.updated,
    learning.inserted,
    learning.staged,
    learning.met,
)

END = """## Reading on

[paper.md](paper.md) says which of these rules are the paper's and which are readings of ours;
[the card of dual-memory](controllers/dual-memory.md) has all settings; [theory.md](theory.md),
how fast the memories grow."""


def one_decision_markdown() -> str:
    """Run the scenario and return the page: markdown, the same on every machine."""
    return markdown_of(shown_trace())


def shown_trace() -> Trace:
    """Return the run that the page is about."""
    made = scenario(SCENARIO, horizon_s=HORIZON_S)
    return Trace(made, REWARD, SEED, DualMemorySettings())


def markdown_of(trace: Trace) -> str:
    """Return the page about a run on a grid under the reward "diffusion"."""
    story = best_story(trace)
    sections = (section(story) for section in SECTIONS)
    return wrapped("\n\n".join((_beginning(story), *sections, END))) + "\n"


def best_story(trace: Trace) -> Story:
    """Choose the decision at which there is most to see, and the staging of most fates."""
    decisions = trace.decisions()
    decision = max(decisions, key=worth_showing)

    def fates(staging: Decision) -> tuple[int, bool]:
        return (
            len({row.outcome for row in trace.staging(staging)}),
            staging.agent == decision.agent,
        )

    return Story(trace, decision, max((each for each in decisions if each.stages), key=fates))


def worth_showing(decision: Decision) -> tuple[int, ...]:
    """Return how much there is to see in a decision, what matters most first."""
    long, short = decision.long, decision.short
    return (
        bool(long and short and not decision.explored and not decision.stages),
        bool(long and short and long.action != short.action),
        sum(bool(answer and answer.variant) for answer in (long, short)),
        bool(decision.known and decision.following),
        decision.last_found.short_row != ABSENT,
        int((decision.state > 0).sum()),
    )


def _beginning(story: Story) -> str:
    trace, decision = story.trace, story.decision
    memory, agent = decision.moment.memory, story.agent
    timing, horizon_s = trace.scenario.timing, trace.scenario.horizon_s
    start = trace.moments[0].memory.long.rows.size[agent]
    return f"""# One decision in numbers

This page follows one decision of the paper's dual-memory agent, from the queues that it sees to
what it remembers afterwards. The agents controlled `{trace.scenario.name}` with the reward
`{REWARD}` and the classes `{trace.embedding.name}` (seed {SEED}, all settings at their defaults),
and the page was written from their memories by `dmil.reports.one_decision`. Numbers are rounded
only where they are shown.

First a dummy agent was trained for {horizon_s} s: exact SARSA, one table for all intersections,
{trace.prior.table.rows.size[0]} states at the end. The part κ =
{plain(trace.settings.staged_ratio)} of them with the highest Q, each with its best action, went
into the long-term memory that every agent starts with, {start} classes (Algorithm 2). Then
{decision.moment.action.size} agents controlled other vehicles for {horizon_s} s and decided every
{timing.decision_interval_s} s. We look at intersection {story.place(agent)} at t =
{decision.moment.observation.time_s} s. Its agent now has {memory.long.rows.size[agent]} classes
in long-term memory and {memory.short.rows.size[agent]} in short-term memory."""
