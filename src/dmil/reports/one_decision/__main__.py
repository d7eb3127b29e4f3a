"""``python -m dmil.reports.one_decision FILE``: write the page into a file."""

import sys
from pathlib import Path

from dmil.files import write_text_atomically
from dmil.reports.one_decision.page import one_decision_markdown

if __name__ == "__main__":
    write_text_atomically(Path(sys.argv[1]), one_decision_markdown())
