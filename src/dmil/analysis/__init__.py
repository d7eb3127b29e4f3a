"""From results to tables to claims with verdicts."""

from dmil.analysis.cells import Cells, cells_of
from dmil.analysis.claims import claims
from dmil.analysis.paper import TABLE_II, Architecture, PaperValue, Reading
from dmil.analysis.questions import Question, Statement
from dmil.analysis.statements import STATEMENTS
from dmil.analysis.study import Tables, tables_of
from dmil.analysis.tables import curves, paper_table, sensitivity, summary

__all__ = [
    "STATEMENTS",
    "TABLE_II",
    "Architecture",
    "Cells",
    "PaperValue",
    "Question",
    "Reading",
    "Statement",
    "Tables",
    "cells_of",
    "claims",
    "curves",
    "paper_table",
    "sensitivity",
    "summary",
    "tables_of",
]
