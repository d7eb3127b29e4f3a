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


def test_lemma_3_alone_is_called_false_and_the_remark_is_credited() -> None:
    (lemma,) = [statement for statement in STATEMENTS if statement.verdict == "false"]
    assert lemma.source == "Lemma 3"
    assert "Remark in §V" in lemma.reason


def test_the_papers_bound_on_the_staging_ratio_is_called_true() -> None:
    (bound,) = [statement for statement in STATEMENTS if statement.name == "bound on κ"]
    assert bound.verdict == "true"


def test_markdown_leaves_nothing_out() -> None:
    text = statements_markdown()
    for statement in STATEMENTS:
        for part in (statement.source, statement.verdict, statement.corrected, statement.reason):
            assert part in text


def test_the_docs_show_the_table_as_it_is() -> None:
    # To mend: replace the sections of docs/theory.md after "## The statements" by the output of
    # python -c "from dmil.theory import statements_markdown; print(statements_markdown(), end='')"
    below = DOCS.read_text(encoding="utf-8").split("## The statements\n\n")[1]
    assert below[below.index("### ") :] == statements_markdown()
