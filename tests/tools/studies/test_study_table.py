"""The columns of a study's table."""

from __future__ import annotations

import pytest

from tests.tools.studies.study_result import result_of
from tools.studies.study import Case
from tools.studies.study_table import table


def _row(outcomes: list[str], reach_s: list[float | None]) -> dict[str, float | None]:
    result = result_of(Case(()), 1, None)
    result.figures["meetings"] = [{"outcome": outcome} for outcome in outcomes]
    result.figures["reach_s"] = reach_s
    (row,) = table([result]).values()
    return {name: summary and summary.mean for name, summary in row.items()}


def test_meetings_that_the_end_cuts_off_are_no_failures() -> None:
    outcomes = ["turned back", "avoided", "avoided", "passed by", "cut off"]
    assert _row(outcomes, [1.0])["meetings_ended"] == pytest.approx(0.75)
    assert _row(["cut off"], [1.0])["meetings_ended"] is None


def test_robots_that_never_came_to_the_border_lower_the_share_of_those_that_arrived() -> None:
    assert _row([], [3.0, None, 5.0, 0.0])["arrived"] == pytest.approx(0.75)
