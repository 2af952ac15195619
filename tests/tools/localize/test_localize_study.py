"""The accuracy study: its scans and maps, its limits, its table."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from tools.localize.localize_report import STUDIES, format_table, run_count, run_study
from tools.localize.localize_study import StudyLog, accuracy, read_study_log
from tools.logs.carmen import LogError, read_carmen


@pytest.fixture(scope="module")
def path(data_folder: Path) -> Path:
    return data_folder / "logs" / "seattle-corrected.log.gz"


@pytest.fixture(scope="module")
def seattle(path: Path) -> StudyLog:
    return read_study_log(path, 27)


def test_hold_out_scans_are_not_in_the_map(path: Path, seattle: StudyLog) -> None:
    scans = read_carmen(path).scans
    assert seattle.name == "seattle"
    assert [step.t for step in seattle.steps] == [scan.t for scan in scans[27:]]
    assert [step.t for step in seattle.odd_steps] == [scan.t for scan in scans[27::2]]
    assert (seattle.map.map.cells == 1).sum() > (seattle.even_map.map.cells == 1).sum()


def test_map_is_of_every_so_many_scans_and_the_scans_stay(path: Path, seattle: StudyLog) -> None:
    sparse = read_study_log(path, 27, map_every=3)
    assert (sparse.map.map.cells != 2).sum() < (seattle.map.map.cells != 2).sum()
    assert len(sparse.steps) == len(seattle.steps)


def test_accuracy_meets_the_targets(seattle: StudyLog) -> None:
    """Issue: 0.022 m RMSE, 0.042 m p95, heading under 0.6 degrees, never lost; hold-out 0.04 m."""
    calls: list[float] = []
    (row,) = accuracy([seattle], 2, progress=calls.append)
    assert calls == [1, 2]
    assert row["worst_rmse_m"] < 0.022
    assert row["worst_p95_m"] < 0.042
    assert row["worst_heading_deg"] < 0.6
    assert row["lost"] == 0.0
    (row,) = accuracy([seattle], 2, hold_out=True)
    assert row["worst_rmse_m"] < 0.04


def test_every_study_runs_by_its_name(seattle: StudyLog) -> None:
    short = replace(seattle, odd_steps=seattle.odd_steps[:20])
    assert run_count("accuracy", 3, 20, 100) == 60
    assert run_count("slip", 3, 20, 100) == 100
    for name in STUDIES:
        calls: list[float] = []
        table = run_study(name, [short], 1, 1, calls.append)
        assert table[0]["log"] == "seattle"
        assert calls == [1]


def test_table_is_aligned() -> None:
    table = [
        {"log": "a", "rmse_m": 0.1234, "seeds": 2},
        {"log": "long", "rmse_m": 1.0, "seeds": 20},
    ]
    assert format_table(table) == (
        "log   rmse_m  seeds\n"
        "a      0.123      2\n"
        "long   1.000     20"
    )  # fmt: skip


def test_first_scan_beyond_the_end_is_an_error(path: Path) -> None:
    with pytest.raises(LogError, match="no scan"):
        read_study_log(path, 999)
