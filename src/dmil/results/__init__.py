"""What happened in a study, written down once: schema, writer, reader, manifest."""

from dmil.results.manifest import provenance, read_manifest, write_manifest
from dmil.results.reader import Results
from dmil.results.schema import (
    RUNS,
    RUNS_SCHEMA,
    SCHEMA_VERSION,
    SERIES,
    SERIES_SCHEMA,
    TABLES,
    Column,
    Table,
    schema_markdown,
)
from dmil.results.writer import write_recording, write_results

__all__ = [
    "RUNS",
    "RUNS_SCHEMA",
    "SCHEMA_VERSION",
    "SERIES",
    "SERIES_SCHEMA",
    "TABLES",
    "Column",
    "Results",
    "Table",
    "provenance",
    "read_manifest",
    "schema_markdown",
    "write_manifest",
    "write_recording",
    "write_results",
]
