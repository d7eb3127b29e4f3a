"""The page about one decision is what the code writes, and what it writes is what happened."""

from pathlib import Path

import numpy as np
import pytest

from dmil.controllers.tabular.choice import uniform_action
from dmil.memory import ABSENT, look_up
from dmil.reports.one_decision.page import best_story, markdown_of, shown_trace
from dmil.reports.one_decision.story import decimal, subtracted, wrapped

PAGE = Path(__file__).parents[3] / "docs" / "one-decision.md"


@pytest.fixture(scope="module")
def trace():
    return shown_trace()


def found(trace, rows, agent, key):
    return look_up(rows, trace.classes, agent, trace.classes.shape[agent], key, trace.scratch)


def test_docs_hold_the_page(trace):
    # To mend: python -m dmil.reports.one_decision docs/one-decision.md
    assert PAGE.read_text(encoding="utf-8") == markdown_of(trace)


def test_the_decision_shown_meets_both_memories_and_does_not_explore(trace):
    decision = best_story(trace).decision
    assert decision.long is not None
    assert decision.short is not None
    assert not decision.explored


def test_every_action_is_what_the_draws_and_the_memories_told_say(trace):
    seen = set()
    for decision in trace.decisions():
        draw = decision.moment.draws[decision.agent]
        expected = decision.recalled
        if decision.explored or expected == ABSENT:
            expected = uniform_action(draw[1], 8)
        assert decision.action == expected
        seen.add((decision.explored, decision.recalled == ABSENT))
    assert len(seen) == 4


def test_every_new_q_told_stands_in_short_term_memory_afterwards(trace):
    kept = [each for each in trace.decisions() if not each.stages]
    for decision in kept:
        agent, short = decision.agent, decision.after.short
        row, variant = found(trace, short.rows, agent, decision.last_key)
        stored = trace.turned(agent, variant, decision.last_action)
        assert short.tried[agent, row, stored]
        assert short.value[agent, row, stored] == pytest.approx(decision.learned, abs=1e-12)
    assert len(kept) > 100


def test_every_outcome_of_a_staging_told_stands_in_long_term_memory_afterwards(trace):
    outcomes = set()
    for decision in trace.decisions():
        if not decision.stages:
            continue
        agent, long = decision.agent, decision.after.long
        grown = long.rows.size[agent] - decision.moment.memory.long.rows.size[agent]
        rows = trace.staging(decision)
        assert grown == sum(row.outcome == "new" for row in rows)
        for row in rows:
            place, variant = found(trace, long.rows, agent, row.key)
            if row.outcome in ("new", "replaces"):
                # A better row of the same class may have been staged before, no better one after.
                assert long.value[agent, place] == pytest.approx(row.value)
                assert long.action[agent, place] == trace.turned(agent, variant, row.action)
            elif row.outcome == "refused":
                assert row.value <= row.known + 0.1 * abs(row.known)
            outcomes.add(row.outcome)
    assert outcomes == {"new", "replaces", "refused", "forgotten"}


def test_the_reward_told_is_the_mean_of_the_signed_squares(trace):
    for decision in trace.decisions():
        growth = (decision.state - decision.last_state).astype(float)
        assert decision.reward == pytest.approx(-np.mean(np.sign(growth) * growth**2))


def test_a_meeting_leaves_all_agents_with_one_memory(trace):
    before, after, common = trace.meeting()
    assert 0 < common <= before.rows.size.min()
    assert (after.rows.size == after.rows.size[0]).all()
    assert (after.value == after.value[:1])[:, : after.rows.size[0]].all()


def test_numbers_have_true_minus_signs_and_no_negative_zero():
    assert decimal(-0.0004) == "0.000"
    assert decimal(-1.25, 1) == "−1.2"
    assert subtracted(-0.5) == "(−0.500)"


def test_paragraphs_are_broken_but_code_and_tables_are_not():
    code = "`" + " · ".join(["0 0 0"] * 4) + "`"
    text = wrapped(
        f"## Head\n\n{'word ' * 18}  key {code}.\n\n| {code} | {code} | {code} | {code} |"
    )
    head, paragraph, table = text.split("\n\n")
    assert head == "## Head"
    assert paragraph.splitlines()[1] == f"{code}."
    assert len(table.splitlines()) == 1
