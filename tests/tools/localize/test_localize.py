"""Localization alone on a log: summary, rows, options."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from maps.map_folder import MapFolder, load_map_folder
from maps.occupancy_map import save_map
from maps.pose import Pose
from tools.localize.localize import LocalizeOptions, localize_steps, log_steps
from tools.localize.localize_result import LocalizeResult
from tools.logs.carmen import CarmenLog, LogError, read_carmen
from tools.logs.log_step import LogStep
from tools.mapping.map_build import build_map

SCANS = 60
STATISTICS = {"median", "mean", "rmse", "p95", "max"}


@pytest.fixture(scope="module")
def log(data_folder: Path) -> CarmenLog:
    whole = read_carmen(data_folder / "logs" / "seattle-corrected.log.gz")
    return replace(whole, scans=whole.scans[27 : 27 + SCANS])


@pytest.fixture(scope="module")
def folder(log: CarmenLog, tmp_path_factory: pytest.TempPathFactory) -> MapFolder:
    path = tmp_path_factory.mktemp("maps") / "seattle"
    save_map(build_map(log).map, path)
    return load_map_folder(path)


def localize(
    log: CarmenLog,
    folder: MapFolder,
    options: LocalizeOptions,
    progress: Callable[[float], None] = lambda _: None,
) -> LocalizeResult:
    return localize_steps(str(log.path), log_steps(log), folder, options, progress)


def test_summary_has_the_documented_keys_and_true_numbers(
    log: CarmenLog, folder: MapFolder
) -> None:
    result = localize(log, folder, LocalizeOptions(seed=3))
    summary = result.summary
    assert list(summary) == [
        "log", "map", "seed", "scans", "lost_share", "position_m", "heading_deg", "inside_95",
        "health_share", "update_ms", "updates_per_s", "particles", "peak_memory_mb",
    ]  # fmt: skip
    assert summary["log"] == str(log.path)
    assert (summary["map"], summary["seed"], summary["scans"]) == ("seattle", 3, SCANS)
    assert set(summary["position_m"]) == STATISTICS == set(summary["heading_deg"])
    assert set(summary["update_ms"]) == {"median", "p95"}
    assert 10 < summary["peak_memory_mb"] < 2000
    errors = np.array(
        [
            math.dist((row.x, row.y), scan.reference[:2])
            for row, scan in zip(result.rows, log.scans, strict=True)
        ]
    )
    assert summary["position_m"]["rmse"] == pytest.approx(np.sqrt(np.mean(errors**2)))
    assert summary["position_m"]["max"] == pytest.approx(errors.max())
    assert summary["position_m"]["rmse"] < 0.03
    assert summary["heading_deg"]["rmse"] < 0.6
    assert summary["lost_share"] == 0.0
    assert summary["particles"]["median"] < 1000
    spent = sum(row.update_ms for row in result.rows)
    assert summary["updates_per_s"] == pytest.approx(1e3 * SCANS / spent)
    assert set(summary["inside_95"]) == {"xy", "pose"}
    assert sum(summary["health_share"].values()) == pytest.approx(1.0)
    assert summary["health_share"]["localized"] > 0.9


def test_csv_holds_the_rows_of_the_result(
    log: CarmenLog, folder: MapFolder, tmp_path: Path
) -> None:
    result = localize(log, folder, LocalizeOptions())
    result.write_csv(tmp_path / "out.csv")
    with (tmp_path / "out.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == SCANS
    assert float(rows[5]["x"]) == result.rows[5].x
    assert rows[-1]["health"] == "localized"


def test_progress_counts_every_scan(log: CarmenLog, folder: MapFolder) -> None:
    calls: list[float] = []
    localize(log, folder, LocalizeOptions(first_scan=50), calls.append)
    assert calls == list(range(1, SCANS - 50 + 1))


def test_same_seed_gives_the_same_rows(log: CarmenLog, folder: MapFolder) -> None:
    first, again, other = (
        [
            replace(row, update_ms=0.0)
            for row in localize(log, folder, LocalizeOptions(seed=seed, start_noise=True)).rows
        ]
        for seed in (1, 1, 2)
    )
    assert first == again
    assert first != other


def test_particles_option_fixes_their_number(log: CarmenLog, folder: MapFolder) -> None:
    result = localize(log, folder, LocalizeOptions(particles=321, beams=30))
    assert {row.particles for row in result.rows} == {321}


def test_steps_without_reference_have_no_errors(log: CarmenLog, folder: MapFolder) -> None:
    steps = [LogStep(s.t, s.odometry, s.points(), None) for s in log.scans]
    options = LocalizeOptions(start=log.scans[0].reference)
    result = localize_steps("recording", steps, folder, options)
    assert set(result.summary["position_m"].values()) == {None}
    assert result.rows[0].position_error_m is None
    assert result.summary["lost_share"] is None
    with pytest.raises(LogError, match="--global"):
        localize_steps("recording", steps, folder, LocalizeOptions())


def test_estimate_far_from_the_reference_counts_as_lost(log: CarmenLog, folder: MapFolder) -> None:
    shifted = [
        LogStep(s.t, s.odometry, s.points(), Pose(s.reference.x + 5, s.reference.y, 0))
        for s in log.scans
    ]
    options = LocalizeOptions(start=log.scans[0].reference)
    assert localize_steps("x", shifted, folder, options).summary["lost_share"] == 1.0


def test_unknown_start_is_localized(log: CarmenLog, folder: MapFolder) -> None:
    result = localize(log, folder, LocalizeOptions(anywhere=True))
    assert result.rows[0].health == "lost"
    assert result.rows[-1].health == "localized"
    assert result.rows[-1].position_error_m < 0.2


def test_first_scan_beyond_the_end_is_an_error(log: CarmenLog, folder: MapFolder) -> None:
    with pytest.raises(LogError, match="no scan"):
        localize(log, folder, LocalizeOptions(first_scan=999))
