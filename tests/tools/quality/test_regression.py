"""Decisions equal the reference; ``patrol regression --update`` accepts a change."""

from __future__ import annotations

from pathlib import Path

import pytest

from tools.quality.regression import (
    CASES,
    Case,
    RegressionError,
    chosen_cases,
    decisions,
    difference,
    read_reference,
    write_reference,
)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_decisions_equal_the_reference(case: Case) -> None:
    try:
        now = decisions(case)
    except RegressionError as error:
        pytest.skip(str(error))
    changed = difference(read_reference(case), now)
    assert not changed, "\n".join([*changed, "meant? then run: patrol regression --update"])


def test_difference_shows_both_sides() -> None:
    kept = ["r 1.0 a", "r 1.1 b", "r 1.2 c"]
    assert difference(kept, kept) == []
    assert difference(kept, ["r 1.0 a", "r 1.1 x"]) == [
        "2 of 3 decisions differ (3 kept, 2 now)",
        "  kept: r 1.1 b",
        "  now:  r 1.1 x",
        "  kept: r 1.2 c",
        "  now:  (none)",
    ]


def test_reference_is_read_back_and_damage_is_an_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tools.quality.regression.REFERENCES", tmp_path)
    case = Case("one", lambda _folder: [])
    assert read_reference(case) == []
    write_reference(case, ["a", "b"])
    assert read_reference(case) == ["a", "b"]
    case.reference.write_bytes(b"x")
    with pytest.raises(RegressionError, match="--update"):
        read_reference(case)


def test_unknown_case_is_an_error_naming_the_known_ones() -> None:
    with pytest.raises(RegressionError, match="cases are two_robots_meet, real_log"):
        chosen_cases(["nothing"])
