"""Outcomes of rows and their table."""

from __future__ import annotations

from tools.field.field_row import FieldRow, Outcome, markdown


def row(name: str) -> FieldRow:
    return FieldRow(name, "pulled | put back", "drives", lambda _stage, _outcome: None)


def test_a_time_within_its_limit_is_measured_and_no_complaint() -> None:
    outcome = Outcome()
    outcome.within("at rest after", 1.24, 2.0)
    assert (outcome.measured, outcome.complaints) == (["at rest after 1.2 s"], [])


def test_what_is_late_or_never_happens_is_a_complaint() -> None:
    outcome = Outcome()
    outcome.within("drives after", 61.0, 60.0)
    outcome.within("at rest after", None, 2.0)
    assert outcome.measured == ["drives after 61.0 s", "at rest after never"]
    assert outcome.complaints == ["drives after: over 60 s", "at rest after: over 2 s"]


def test_what_must_hold_and_does_not_is_a_complaint() -> None:
    outcome = Outcome()
    outcome.require(1 + 1 == 2, "adds wrongly")
    outcome.require(1 + 1 == 3, "not three")
    assert outcome.complaints == ["not three"]


def test_the_table_has_a_line_per_row_and_its_verdict() -> None:
    bad = Outcome(["never"], ["over\n2 s"])
    assert markdown([(row("a"), Outcome()), (row("b"), bad)]) == (
        "| row | what was done | what must hold | measured | verdict |\n"
        "| --- | --- | --- | --- | --- |\n"
        "| a | pulled / put back | drives | - | ok |\n"
        "| b | pulled / put back | drives | never | over 2 s |\n"
    )
