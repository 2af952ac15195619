"""No change of decisions goes unnoticed: accept one by ``patrol regression --update``."""

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
def test_decisions_are_those_kept(case: Case) -> None:
    try:
        now = decisions(case)
    except RegressionError as error:
        pytest.skip(str(error))
    changed = difference(read_reference(case), now)
    assert not changed, "\n".join([*changed, "meant? then run: patrol regression --update"])


def test_a_difference_is_shown_with_both_sides() -> None:
    kept = ["r 1.0 a", "r 1.1 b", "r 1.2 c"]
    assert difference(kept, kept) == []
    assert difference(kept, ["r 1.0 a", "r 1.1 x"]) == [
        "2 of 3 decisions differ (3 kept, 2 now)",
        "  kept: r 1.1 b",
        "  now:  r 1.1 x",
        "  kept: r 1.2 c",
        "  now:  (none)",
    ]


def test_reference_comes_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tools.quality.regression.REFERENCES", tmp_path)
    case = Case("one", lambda _folder: [])
    assert read_reference(case) == []
    write_reference(case, ["a", "b"])
    assert read_reference(case) == ["a", "b"]
    case.reference.write_bytes(b"x")
    with pytest.raises(RegressionError, match="--update"):
        read_reference(case)


def test_unknown_case_is_named() -> None:
    with pytest.raises(RegressionError, match="cases are two_robots_meet, real_log"):
        chosen_cases(["nothing"])
