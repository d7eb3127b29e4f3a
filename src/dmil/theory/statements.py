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
    printed: str
    """As the paper has it; a dash if it is ours."""
    corrected: str
    """As it should read; the same text where it is true."""
    verdict: Verdict
    """true; corrected (a true statement is close); false (it has counterexamples); added (ours)."""
    reason: str
    """The proof, or the counterexample."""


def _true(name: str, source: str, statement: str, reason: str) -> Statement:
    return Statement(name, source, statement, statement, "true", reason)


STATEMENTS: tuple[Statement, ...] = (
    Statement(
        "short-term recurrence",
        "Definition 1",
        "m_s[t] = (m_s[t−1] + 1)(1 − I[t]), m_s[0] = 1",
        "m_s[t] = 1 + m_s[t−1](1 − I[t]), m_s[0] = 1, while all states are new",
        "corrected",
        "As printed, m_s[nT] = 0 and m_s[2T−1] = T − 1, but the proof of Lemma 1 uses 1 and T. "
        "Corrected, m_s[t] = (t mod T) + 1. A state met again since the last staging adds no row.",
    ),
    Statement(
        "ratio at the start",
        "Definition 1",
        "ζ = 1 at t = 0",
        "ζ = 1 at t = 0 ⟺ long-term memory starts empty",
        "corrected",
        "ζ[0] = |A| / (|A| + 3·m_L[0]).",
    ),
    _true(
        "worst case after staging",
        "Lemma 1",
        "ζ1 = (nT+1)|A| / (|A| + 3nκT) ≥ 1 ⟺ |A| ≥ 3κ",
        "Numerator − denominator = nT(|A| − 3κ).",
    ),
    _true(
        "worst case before staging",
        "Lemma 1",
        "ζ2 = nT|A| / (T|A| + 3(n−1)κT) ≥ 1 for |A| ≥ 3κ",
        "Numerator − denominator = (n−1)T(|A| − 3κ), so ζ2 = 1 at n = 1 whatever κ is.",
    ),
    _true(
        "worst case at any decision",
        "Lemma 1",
        "ζ ≥ 1 at every t while all states are new, if |A| ≥ 3κ",
        "At t = nT + r, 0 ≤ r < T: |A|m_Q − msize of dual memory = nT(|A| − 3κ).",
    ),
    Statement(
        "order of the worst-case ratios",
        "proof of Lemma 1",
        "ζ1 ≥ ζ2 ⟹ |A| ≥ 3κ(T+2)/(T−2), so T > 2",
        "ζ1 ≥ ζ2 ⟺ |A| ≥ 3κ, for every T ≥ 1 and n ≥ 1",
        "false",
        "The cross product ζ1 − ζ2 has the sign of (|A| − 3κ)(n(T−1) + 1). "
        "|A| = 4, κ = 1, T = 3, n = 1: ζ1 = 16/13 ≥ ζ2 = 1, yet 4 < 15.",
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
        "m_L ≤ M; equality once every class has been staged, which may never happen",
        "false",
        "A staging adds at most ⌈κ·min(T, M)⌉ rows, and by value it may pick the same rows again. "
        "One row of two staged, T = 2, M = 2: n = 1 gives m_L = 1.",
    ),
    Statement(
        "short-term memory in the best case",
        "proof of Lemma 2",
        "ζ2 = M|A| / (T|A| + 3M)",
        "ζ2 = M|A| / (min(T, M)|A| + 3M)",
        "corrected",
        "Short-term memory holds distinct states, at most M. For M ≤ T, ζ2 = |A|/(|A|+3) < 1.",
    ),
    _true(
        "best-case thresholds",
        "proof of Lemma 2",
        "for |A| > 3: ζ1 ≥ 1 ⟺ M ≥ |A|/(|A|−3), ζ2 ≥ 1 ⟺ M ≥ T|A|/(|A|−3)",
        "M|A| ≥ k|A| + 3M ⟺ M(|A|−3) ≥ k|A|, k = 1 or T; the second threshold exceeds T, so "
        "min(T, M) changes nothing. For |A| ≤ 3 no M is enough.",
    ),
    Statement(
        "best case",
        "Lemma 2",
        "ζ ≥ 1 in the best case if |A| ≥ 3κ",
        "ζ ≥ 1 in the best case if |A| > 3 and M ≥ T|A|/(|A|−3)",
        "corrected",
        "|A| ≥ 3κ is not enough: |A| = 8, T = 16, M = 25 has ζ2 = 200/203.",
    ),
    Statement(
        "any time, any trajectory",
        "Lemma 3",
        "msize of dual memory ≤ msize of SARSA at any time t, for any trajectory",
        "ζ[t] ≥ 1 whenever |A| > 3 and m_Q[t] ≥ T|A|/(|A|−3)",
        "false",
        "The extremes bound each size, not the ratio. |A| = 8, κ = ½, T = 16: 17 distinct states, "
        "then revisits of 15 of the first 16 give ζ = 136/152 = .895; one state met T + 1 times "
        "gives |A|/(|A|+3). Corrected: m_s ≤ T, m_L ≤ m_Q, so "
        "|A|m_Q − |A|m_s − 3m_L ≥ (|A|−3)m_Q − T|A| ≥ 0.",
    ),
    Statement(
        "bound on κ",
        "Remark 2",
        "κ ≤ |A|/3 is required",
        "κ ≤ |A|/3 says nothing for |A| ≥ 3",
        "corrected",
        "κ ≤ 1 ≤ |A|/3.",
    ),
    Statement(
        "bound on T",
        "Remark 2",
        "T > 2 is required",
        "T ≥ 1",
        "false",
        "It rests on the printed (T+2)/(T−2) alone.",
    ),
    _true(
        "effect of κ",
        "Remark 2",
        "decreasing κ increases ζ",
        "In the worst case both denominators grow with κ (ζ2 from n = 2 on); "
        "the best-case ratios do not depend on κ.",
    ),
    _true(
        "effect of T",
        "Remark 2",
        "a larger T slows the convergence of ζ2 to ζ1, and needs a larger M",
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
        "m_L ≤ m_Q needs classes that are the same wherever they are looked up",
        "added",
        "True of exact states and cells. With first-key-wins keys within a tolerance, short-term "
        "memory chooses its keys anew after each staging: long-term memory may hold 0 and 2 where "
        "the Q-table holds 1. Then m_L > m_Q, and even the corrected Lemma 3 can fail. "
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
