"""What the paper's analysis states, as printed and as it should read.

The report, the command line and docs/theory.md render this one table.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Verdict = Literal["true", "corrected", "false", "added"]


@dataclass(frozen=True, slots=True)
class Statement:
    """One statement of the analysis."""

    name: str
    source: str
    """Where the paper has it. Lemmas 1, 2 and 3 are those of §V in their order: "Worst-Case
    Trajectory", "Best-Case Trajectory", "Comparison Ratio of Dual-Memory and SARSA"; the remark
    there is "Optimal Hyperparameter Design"."""
    printed: str
    """As the paper has it; a dash if it is ours."""
    corrected: str
    """As it should read; the same text where it is true."""
    verdict: Verdict
    """true, under conditions that the paper itself states; corrected (true with the change shown);
    false (it has counterexamples); added (ours)."""
    reason: str
    """The proof, or the counterexample."""


def _true(name: str, source: str, statement: str, reason: str) -> Statement:
    return Statement(name, source, statement, statement, "true", reason)


STATEMENTS: tuple[Statement, ...] = (
    Statement(
        "short-term recurrence",
        "Definition in §V",
        "m_s[t] = (m_s[t−1] + 1)(1 − I[t]), m_s[0] = 1",
        "m_s[t] = 1 + m_s[t−1](1 − I[t]), m_s[0] = 1, while all states are new",
        "corrected",
        "As printed, m_s[nT] = 0 and m_s[2T−1] = T − 1, but the proof of Lemma 1 uses 1 and T. "
        "Corrected, m_s[t] = (t mod T) + 1. A state met again since the last staging adds no row.",
    ),
    _true(
        "ratio at the start",
        "Definition in §V",
        "ζ = 1 at t = 0",
        "Both hold one state: the proof of Lemma 1 sets m_L[0] = 0. Agents that start from a "
        "trained table, as in §VI-B, start with another ratio.",
    ),
    _true(
        "worst case after staging",
        "proof of Lemma 1",
        "ζ1 = (nT+1)|A| / (|A| + 3nκT) ≥ 1 ⟺ |A| ≥ 3κ",
        "Numerator − denominator = nT(|A| − 3κ).",
    ),
    _true(
        "worst case before staging",
        "proof of Lemma 1",
        "ζ2 = nT|A| / (T|A| + 3(n−1)κT) ≥ 1 for |A| ≥ 3κ",
        "Numerator − denominator = (n−1)T(|A| − 3κ), so ζ2 = 1 at n = 1 whatever κ is.",
    ),
    _true(
        "worst case at any decision",
        "Lemma 1",
        "ζ ≥ 1 while all states are new, if |A| ≥ 3κ",
        "At t = nT + r, 0 ≤ r < T: |A|m_Q − msize of dual memory = nT(|A| − 3κ). It is the same "
        "for every r, so looking at the two ends of a period is enough, as the proof says.",
    ),
    Statement(
        "order of the worst-case ratios",
        "proof of Lemma 1",
        "ζ1 ≥ ζ2 gives |A| ≥ 3κ(T+2)/(T−2), so T > 2",
        "ζ1 ≥ ζ2 ⟺ |A| ≥ 3κ, for every T ≥ 1 and n ≥ 1",
        "corrected",
        "ζ1 − ζ2 has the sign of (|A| − 3κ)(n(T−1) + 1). The printed condition is enough for "
        "T > 2, but not necessary: |A| = 4, κ = ½, T = 4, n = 1 gives ζ1 = 2 ≥ ζ2 = 1, yet "
        "4 < 4.5. Lemma 1 itself does not rest on it.",
    ),
    Statement(
        "limit of the worst case",
        "ours",
        "–",
        "ζ1 → |A|/(3κ) and ζ2 → |A|/(3κ) as n → ∞",
        "added",
        "Ratio of the coefficients of n.",
    ),
    Statement(
        "long-term memory in the best case",
        "Lemma 2",
        "m_L[τ + nT] = M for n > 0",
        "m_L ≤ M, with equality once every class has been staged, which may never happen",
        "corrected",
        "A staging adds at most ⌈κ·min(T, M)⌉ rows, and by value it may pick the same rows again: "
        "κ = ½, T = 2, M = 2 gives m_L = 1 at n = 1. The proof needs no more than m_L ≤ M, "
        "because a smaller m_L only raises ζ.",
    ),
    Statement(
        "ratios of the best case",
        "proof of Lemma 2",
        "ζ1 = M|A| / (|A| + 3M), ζ2 = M|A| / (T|A| + 3M)",
        "ζ1 ≥ M|A| / (|A| + 3M), ζ2 ≥ M|A| / (T|A| + 3M), with equality at m_L = M",
        "corrected",
        "As m_L ≤ M above. With m_L = M, and T distinct states since the last staging: the least "
        "that ζ can be. It takes M ≥ T, and the proof asks M > T. With fewer states short-term "
        "memory has at most M rows; `best_case` therefore takes min(T, M) for T.",
    ),
    _true(
        "best-case thresholds",
        "proof of Lemma 2",
        "for |A| > 3: ζ1 ≥ 1 ⟺ M ≥ |A|/(|A|−3), ζ2 ≥ 1 ⟺ M ≥ T|A|/(|A|−3)",
        "M|A| ≥ k|A| + 3M ⟺ M(|A|−3) ≥ k|A|, k = 1 or T; the second threshold exceeds T, so "
        "min(T, M) changes nothing. For |A| ≤ 3 no M is enough.",
    ),
    _true(
        "order of the best-case ratios",
        "proof of Lemma 2",
        "ζ1 ≥ ζ2",
        "T|A| + 3M ≥ |A| + 3M, for every T ≥ 1.",
    ),
    Statement(
        "best case",
        "Lemma 2",
        "ζ ≥ 1 in the best case under the assumptions of Lemma 1, |A| ≥ 3κ",
        "ζ ≥ 1 in the best case if |A| > 3 and M ≥ T|A|/(|A|−3)",
        "corrected",
        "The corrected conditions are the paper's: its proof derives both. |A| ≥ 3κ alone is not "
        "enough: |A| = 8, T = 16, M = 25 gives ζ2 = 200/203.",
    ),
    _true(
        "growth at a staging",
        "proof of Lemma 3",
        "a staging adds at most κ·m_s states to long-term memory",
        "It takes that many rows (whole rows: ⌈κ·m_s⌉), some of which may be there already.",
    ),
    _true(
        "long-term memory against the Q-table",
        "§IV-B",
        "the overall size of long-term memory never exceeds that of a typical Q-table",
        "For a Q-table of states, as the SARSA agent's: every key of long-term memory is a state "
        "that was met, so m_L ≤ m_Q and 3·m_L ≤ |A|·m_Q for |A| ≥ 3; the Remark in §V asks "
        "|A| > 3. For a Q-table of classes see the last statement.",
    ),
    Statement(
        "any time",
        "Lemma 3",
        "msize of dual memory ≤ msize of SARSA at any time t; by its proof, for any trajectory",
        "ζ[t] ≥ 1 if |A| > 3 and m_Q[t] ≥ T|A|/(|A|−3)",
        "false",
        "Without a condition on the states met it fails: one state met T + 1 times gives "
        "ζ = |A|/(|A|+3); with |A| = 8, κ = ½, T = 16, meeting 17 distinct states and then 15 of "
        "the first 16 again gives ζ = 136/152 = .895. The worst and the best case bound each "
        "size, not the ratio. The paper's Remark in §V supplies the condition (next statement).",
    ),
    Statement(
        "condition of Lemma 3",
        "Remark in §V",
        "for Lemma 3 to hold: |A| > 3 and M ≥ T|A|/(|A|−3)",
        "for Lemma 3 to hold at t: |A| > 3 and m_Q[t] ≥ T|A|/(|A|−3)",
        "corrected",
        "The condition is the paper's. Lemma 2 introduces M as \"the number of all unique "
        'encountered states" of a run that meets no new ones any more; at any earlier time the '
        "states that count are those met so far, m_Q[t]. With M alone: the run of 136/152 above "
        "that goes on to meet 43 new states has M = 60 ≥ 25.6 and meets all that the Remark asks, "
        "but at t = 31 it has met 17 states, and ζ = 136/152. The proof is ours: m_s ≤ T and "
        "m_L ≤ m_Q, so |A|m_Q − |A|m_s − 3m_L ≥ (|A|−3)m_Q − T|A| ≥ 0.",
    ),
    _true(
        "bound on κ",
        "Remark in §V",
        "κ ≤ |A|/3",
        'It is the condition of Lemma 1, and the proof there says itself that it "is relevant for '
        'small action space as 0 < κ < 1": it binds only for |A| ≤ 2.',
    ),
    Statement(
        "bound on T",
        "Remark in §V",
        "T > 2 is required",
        "T ≥ 1 is enough",
        "corrected",
        "T > 2 comes from the printed (T+2)/(T−2) alone. It does no harm, but no other statement "
        "needs it.",
    ),
    _true(
        "effect of κ",
        "Remark in §V",
        "decreasing κ increases ζ",
        "In the worst case both denominators grow with κ (ζ2 from n = 2 on); "
        "the best-case ratios do not depend on κ.",
    ),
    _true(
        "effect of T",
        "Remark in §V",
        "increasing T slows the convergence of ζ2 to ζ1, and raises the M that is needed",
        "At each n the gap ζ1 − ζ2 grows with T for |A| > 3κ; T|A|/(|A|−3) grows with T.",
    ),
    Statement(
        "whole rows",
        "ours",
        "–",
        "Lemma 1 needs |A| ≥ 3⌈κT⌉/T when whole rows are staged",
        "added",
        "κ is in effect ⌈κT⌉/T. |A| = 2, κ = ⅔, T = 1, n = 1: |A| ≥ 3κ, yet ζ1 = 4/5. "
        "Any |A| ≥ 3 is safe.",
    ),
    Statement(
        "what a class must be",
        "ours",
        "–",
        "m_L ≤ m_Q against a Q-table of classes needs classes that are the same wherever looked up",
        "added",
        "Against a Q-table of states it always holds; against one of classes it is true of exact "
        "states and cells. With first-key-wins keys within a tolerance, short-term "
        "memory chooses its keys anew after each staging: long-term memory may hold 0 and 2 where "
        "the Q-table holds 1. Then m_L > m_Q is possible, and ζ < 1 under the condition above. "
        "An agent that receives others' rows needs them counted in m_Q.",
    ),
)


def statements_markdown() -> str:
    """Render the table as markdown, one section for each statement (ours).

    Returns
    -------
    str
        Sections of level 3. Not a markdown table: the bars of |A| would break it.
    """
    sections = []
    for statement in STATEMENTS:
        lines = [f"### {statement.name[0].upper()}{statement.name[1:]}", ""]
        lines += [f"*{statement.source}*: **{statement.verdict}**", ""]
        if statement.verdict != "added":
            lines.append(f"- Printed: {statement.printed}")
        if statement.verdict != "true":
            lines.append(f"- Should read: {statement.corrected}")
        lines.append(f"- Why: {statement.reason}")
        sections.append("\n".join(lines))
    return "\n\n".join(sections) + "\n"
