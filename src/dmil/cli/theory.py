"""``dmil theory``: growth bounds of dual memory for given settings."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

from rich.table import Table
from rich.text import Text

from dmil.cli.options import OUTPUT, Debug, Json, option
from dmil.cli.terminal import number, print_json, say, show, table
from dmil.theory import (
    STATEMENTS,
    Condition,
    Ratios,
    best_case,
    check_hyperparameters,
    failing,
    worst_case,
    worst_case_limit,
)

_MARKS = {True: ("yes", "green"), False: ("no", "red"), None: ("?", "dim")}


def _choice(meaning: str, default: object, metavar: str = "N") -> Any:
    return option("Choice", meaning, metavar, show_default=str(default))


def theory(
    actions: Annotated[int, _choice("|A|: actions of an agent.", 8)] = 8,
    staged_ratio: Annotated[
        float, _choice("κ: fraction of short-term memory that is staged.", 0.5, "X")
    ] = 0.5,
    stage_period: Annotated[int, _choice("T: decisions between stagings.", 16)] = 16,
    stagings: Annotated[int, _choice("n: stagings so far, for the worst case.", 10)] = 10,
    distinct_states: Annotated[
        int, _choice("M: distinct states met, for the best case.", 100)
    ] = 100,
    statements: Annotated[
        bool,
        option(
            OUTPUT, "Print each statement of the paper and what is true of it.", flag="--statements"
        ),
    ] = False,
    plot: Annotated[
        Path | None, option(OUTPUT, "Draw the ratios to a file: .svg, .png, .pdf or .html.", "FILE")
    ] = None,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Bound the growth of dual memory against SARSA's table, and check a choice of its settings.

    For example:
        dmil theory
        dmil theory --actions 4 --staged-ratio 1 --stage-period 30 --plot growth.svg
        dmil theory --statements

    ζ is the size of SARSA's table divided by that of dual memory, both in stored values: above 1,
    dual memory is the smaller. ζ1 is ζ right after a staging, ζ2 right before one. In the worst
    case every decision meets a new state; in the best case no state is new any more. The table
    shows which conditions for ζ ≥ 1 the settings meet. The paper prints some of them with errors:
    --statements shows each as printed and as corrected.
    """
    worst = worst_case(actions, staged_ratio, stage_period, stagings)
    best = best_case(actions, stage_period, distinct_states)
    limit = worst_case_limit(actions, staged_ratio)
    conditions = check_hyperparameters(actions, staged_ratio, stage_period, distinct_states)
    failed = failing(conditions)
    if plot is not None:
        from dmil.reports import save_figure
        from dmil.reports.theory_chart import growth_ratios

        chart = growth_ratios(actions, staged_ratio, stage_period, stagings, distinct_states)
        save_figure(chart, plot)
    if json:
        print_json(
            {
                "worst_case": _ends(worst) | {"limit": limit},
                "best_case": _ends(best),
                "conditions": [asdict(condition) for condition in conditions],
                "failing": [condition.name for condition in failed],
                "statements": [asdict(statement) for statement in STATEMENTS],
                "plot": plot,
            }
        )
        return
    if statements:
        _show_statements()
        return
    show(
        f"|A| = {actions}, κ = {staged_ratio:g}, T = {stage_period}, n = {stagings}, "
        f"M = {distinct_states}",
        "",
        _ratio_table(worst, best, limit),
        "",
        _condition_table(conditions),
        "",
        _verdict(failed),
    )
    if plot is not None:
        say(f"Figure: {plot}")


def _ends(ratios: Ratios) -> dict[str, float]:
    return {"zeta1": float(ratios.zeta1), "zeta2": float(ratios.zeta2)}


def _ratio_table(worst: Ratios, best: Ratios, limit: float) -> Table:
    made = table("!", ">ζ1 after staging", ">ζ2 before staging")
    for name, ratios in (("worst case, after n stagings", worst), ("best case, M states", best)):
        made.add_row(name, *(number(value, 3) for value in _ends(ratios).values()))
    made.add_row("worst case, n → ∞", number(limit, 3), number(limit, 3))
    return made


def _condition_table(conditions: list[Condition]) -> Table:
    made = table("!condition", "!holds", ">here", ">needed", "for what")
    for condition in conditions:
        word, colour = _MARKS[condition.holds]
        printed = "" if condition.decisive else "dim"
        made.add_row(
            Text(condition.statement, printed),
            Text(word, colour if condition.decisive else "dim"),
            *(_bound(value) for value in (condition.found, condition.needed)),
            Text(f"{condition.note} ({condition.source})", printed),
        )
    return made


def _bound(value: float | None) -> str:
    if value is None:
        return "–"
    return "∞" if value == float("inf") else f"{value:.4g}"


def _verdict(failed: list[Condition]) -> Text:
    if not failed:
        return Text("These settings meet all conditions for ζ ≥ 1.", "green")
    reasons = "; ".join(f"{condition.name} ({condition.statement})" for condition in failed)
    return Text(f"These settings fail: {reasons}.", "red")


def _show_statements() -> None:
    for statement in STATEMENTS:
        show(Text(f"{statement.name} ({statement.source}): {statement.verdict}", "bold"))
        if statement.verdict != "added":
            show(f"  printed: {statement.printed}")
        if statement.verdict != "true":
            show(f"  true:    {statement.corrected}")
        show(f"  why:     {statement.reason}", "")
