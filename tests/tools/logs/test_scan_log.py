"""Recordings and CARMEN logs read as one kind of log."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tools.cli import main
from tools.commands.convert import map_of
from tools.logs.carmen import CarmenLog, LogError, read_carmen
from tools.logs.scan_log import read_scan_log
from tools.mapping.slam.rigid_fit import fit
from tools.replay.carmen_recording import convert

SCANS = 60


@pytest.fixture(scope="module")
def log(data_folder: Path) -> CarmenLog:
    whole = read_carmen(data_folder / "logs" / "intel-corrected.log.gz")
    scans = whole.scans[:SCANS]
    knots = [knot for knot in whole.odometry if knot[0] <= scans[-1].t]
    return replace(whole, scans=scans, odometry=knots)


@pytest.fixture(scope="module")
def recording(log: CarmenLog, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("recorded") / "drive.mcap"
    convert(log, map_of(log), path, lambda _: None)
    return path


def test_recording_equals_the_log_it_was_converted_from(log: CarmenLog, recording: Path) -> None:
    read = read_scan_log(recording)
    assert read.referenced
    assert len(read.scans) == SCANS
    for recorded, scan in zip(read.scans, log.scans, strict=True):
        off = scan.reference.between(recorded.reference)
        assert off == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)
        assert recorded.points() == pytest.approx(scan.points(), abs=0.001)
        ranges, angles = recorded.beams()
        true_ranges, true_angles = scan.beams()
        assert ranges == pytest.approx(true_ranges, abs=0.001)
        assert angles == pytest.approx(true_angles, abs=1e-6)
    assert [read.odometry[i][0] for i in read.scan_lines] == [scan.t for scan in read.scans]


@pytest.mark.parametrize("source", ["reference", "odometry"])
def test_map_is_built_from_a_recording(
    recording: Path,
    log: CarmenLog,
    tmp_path: Path,
    source: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["map", "build", str(recording), "-o", str(tmp_path), "--from", source]) == 0
    out = capsys.readouterr().out
    assert f"{SCANS} scans" in out
    assert (tmp_path / "map.yaml").exists()
    assert (tmp_path / "map.png").exists()
    if source == "odometry":
        # No place is revisited so early in the log: compares the chain with the odometry.
        odometry = [scan.odometry for scan in log.scans]
        references = [scan.reference for scan in log.scans]
        frame = fit(odometry, references)
        alone = np.mean(
            [
                math.dist(frame.compose(a)[:2], b[:2])
                for a, b in zip(odometry, references, strict=True)
            ]
        )
        off = float(out.split(" m mean off")[0].rsplit(" ", 1)[1])
        assert off < 0.25 * float(alone)


def test_first_scan_beyond_the_end_is_refused(data_folder: Path) -> None:
    log = read_scan_log(data_folder / "logs" / "seattle-corrected.log.gz")
    rest = log.from_scan(27)
    assert np.array_equal(rest.scans[0].points(), log.scans[27].points())
    assert rest.scan_lines[0] == log.scan_lines[27]
    with pytest.raises(LogError, match="no scan from scan 241 on: the log has 241"):
        log.from_scan(241)
