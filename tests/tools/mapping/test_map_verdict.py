"""Verdicts on maps: good where scans and map agree, failed where odometry folded the map."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest

from maps.pose import Pose
from tools.cli import main
from tools.logs.scan_log import ScanLog, read_scan_log
from tools.mapping.map_build import build_map
from tools.mapping.map_verdict import ODOMETRY_ALONE, Grade, Verdict, judge
from tools.mapping.slam.loop_check import MOST_STRAIN, CheckedLoop

SCANS = 200
MAX_RANGE = 20.0


@pytest.fixture(scope="module")
def log(data_folder: Path) -> ScanLog:
    whole = read_scan_log(data_folder / "logs" / "intel-corrected.log.gz")
    return replace(whole, scans=whole.scans[:SCANS], scan_lines=whole.scan_lines[:SCANS])


def verdict_on(log: ScanLog, unmatched: list[tuple[Pose, float]]) -> Verdict:
    built = build_map(log, max_range=MAX_RANGE)
    return judge(built.map, log.scans, MAX_RANGE, unmatched)


def test_map_of_right_poses_is_good(log: ScanLog) -> None:
    verdict = verdict_on(log, [(Pose(0.0, 0.0, 0.0), 0.9 * ODOMETRY_ALONE)])
    assert verdict.grade is Grade.GOOD
    assert str(verdict).startswith("good: ")


def test_map_of_drifting_odometry_has_failed_and_says_where(log: ScanLog) -> None:
    drifted = log.with_references([scan.odometry for scan in log.scans])
    verdict = verdict_on(drifted, [])
    assert verdict.grade is Grade.FAILED
    assert len(verdict.places) > 20


def test_map_that_folds_once_is_not_good(log: ScanLog) -> None:
    """The second half of the log is turned by 8 degrees about the place between."""
    middle = log.scans[SCANS // 2].reference
    turn = middle.compose(Pose(0.0, 0.0, math.radians(8.0))).compose(middle.inverse())
    poses = [
        turn.compose(scan.reference) if number > SCANS // 2 else scan.reference
        for number, scan in enumerate(log.scans)
    ]
    assert verdict_on(log.with_references(poses), []).grade is not Grade.GOOD


def test_long_stretch_on_odometry_alone_is_doubtful(log: ScanLog) -> None:
    place = Pose(1.0, 2.0, 0.0)
    verdict = verdict_on(log, [(place, 2.0 * ODOMETRY_ALONE)])
    assert verdict.grade is Grade.DOUBTFUL
    assert place in verdict.places
    assert "odometry alone" in str(verdict)


def loop_at(place: Pose, *, kept: bool) -> CheckedLoop:
    return CheckedLoop(place, way=50.0, shift=1.0, turn=0.0, strain=1.0, kept=kept)


def test_loops_that_contradict_the_others_are_doubtful(log: ScanLog) -> None:
    place, built = Pose(1.0, 2.0, 0.0), build_map(log, max_range=MAX_RANGE)
    loops = [loop_at(Pose(0.0, 0.0, 0.0), kept=True) for _ in range(9)]
    assert judge(built.map, log.scans, MAX_RANGE, loops=loops).grade is Grade.GOOD
    contested = judge(built.map, log.scans, MAX_RANGE, loops=[*loops, loop_at(place, kept=False)])
    assert contested.grade is Grade.DOUBTFUL
    assert place in contested.places
    assert "1 of 10 loops contradict" in str(contested)


def test_a_way_bent_beyond_its_errors_is_doubtful(log: ScanLog) -> None:
    place, built = Pose(1.0, 2.0, 0.0), build_map(log, max_range=MAX_RANGE)
    for bend, grade in ((0.9 * MOST_STRAIN, Grade.GOOD), (1.1 * MOST_STRAIN, Grade.DOUBTFUL)):
        verdict = judge(built.map, log.scans, MAX_RANGE, bend=(bend, place))
        assert verdict.grade is grade
        assert (place in verdict.places) == (grade is Grade.DOUBTFUL)


def test_command_exits_with_1_for_a_failed_map_and_still_draws_it(
    log: ScanLog, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A log whose corrected poses are wrong: every other scan is turned by 30 degrees."""
    lines = []
    for number, scan in enumerate(log.scans[:60]):
        readings = " ".join(f"{min(value, 81.91):.2f}" for value in scan.ranges)
        wrong = scan.reference.theta + math.radians(30.0) * (number % 2)
        pose = f"{scan.reference.x} {scan.reference.y} {wrong}"
        raw = f"{scan.odometry.x} {scan.odometry.y} {scan.odometry.theta}"
        lines.append(f"FLASER {len(scan.ranges)} {readings} {pose} {raw} {number} host {number}")
    path = tmp_path / "wrong.log"
    path.write_text("\n".join(lines) + "\n")
    assert main(["map", "build", str(path), "-o", str(tmp_path / "map"), "--max-range", "15"]) == 1
    assert "failed: " in capsys.readouterr().out
    assert (tmp_path / "map" / "map.png").exists()
