"""What an agent remembers: one compiled table under the Q-table, short- and long-term memory."""

from dmil.memory.central import average_best, average_values
from dmil.memory.dual import (
    DualMemory,
    consolidate,
    recall,
    recalled_value,
    remember,
    significantly_better,
    stage,
)
from dmil.memory.imports import import_best, import_values
from dmil.memory.packing import bytes_used, pack, unpack_bests, unpack_values
from dmil.memory.rows import ABSENT, Rows, append, clear, find, make_rows
from dmil.memory.tables import (
    BestTable,
    Scratch,
    ValueTable,
    best_table_with_room,
    best_tried,
    bests_of,
    look_up,
    make_best_table,
    make_scratch,
    make_value_table,
    value_table_with_room,
    values_of,
    write,
)

__all__ = [
    "ABSENT",
    "BestTable",
    "DualMemory",
    "Rows",
    "Scratch",
    "ValueTable",
    "append",
    "average_best",
    "average_values",
    "best_table_with_room",
    "best_tried",
    "bests_of",
    "bytes_used",
    "clear",
    "consolidate",
    "find",
    "import_best",
    "import_values",
    "look_up",
    "make_best_table",
    "make_rows",
    "make_scratch",
    "make_value_table",
    "pack",
    "recall",
    "recalled_value",
    "remember",
    "significantly_better",
    "stage",
    "unpack_bests",
    "unpack_values",
    "value_table_with_room",
    "values_of",
    "write",
]
