"""docs/one-decision.md: one decision of the paper's agent in numbers, told by its own code.

No number on the page is typed by hand. Write it again with

    python -m dmil.reports.one_decision docs/one-decision.md
"""

from dmil.reports.one_decision.page import one_decision_markdown

__all__ = ["one_decision_markdown"]
