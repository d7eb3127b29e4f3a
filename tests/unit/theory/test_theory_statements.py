"""The table of statements, and the docs that show it."""

from __future__ import annotations

from pathlib import Path

from dmil.theory import STATEMENTS, statements_markdown

DOCS = Path(__file__).parents[3] / "docs" / "theory.md"


def test_each_statement_is_complete_and_its_verdict_shows_in_its_texts() -> None:
    assert len({statement.name for statement in STATEMENTS}) == len(STATEMENTS)
    for statement in STATEMENTS:
        assert statement.reason
        assert (statement.verdict == "true") == (statement.printed == statement.corrected)
        assert (statement.verdict == "added") == (statement.printed == "–")
        assert (statement.verdict == "added") == (statement.source == "ours")


def test_lemma_3_is_called_false() -> None:
    (lemma,) = [statement for statement in STATEMENTS if statement.source == "Lemma 3"]
    assert lemma.verdict == "false"


def test_markdown_leaves_nothing_out() -> None:
    text = statements_markdown()
    for statement in STATEMENTS:
        for part in (statement.source, statement.verdict, statement.corrected, statement.reason):
            assert part in text


def test_the_docs_show_the_table_as_it_is() -> None:
    # To mend: replace the part of docs/theory.md after "## The statements" by the output of
    # python -c "from dmil.theory import statements_markdown; print(statements_markdown())"
    shown = DOCS.read_text(encoding="utf-8").split("## The statements\n\n")[1]
    assert shown == statements_markdown()
