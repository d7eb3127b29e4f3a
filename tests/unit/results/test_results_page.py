"""The page about the files of a study says what the schema says."""

from pathlib import Path

from dmil.results import schema_markdown


def test_docs_hold_the_schema():
    page = Path(__file__).parents[3] / "docs" / "results.md"
    assert page.read_text(encoding="utf-8").endswith(schema_markdown())
