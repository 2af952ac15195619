"""``patrol localize`` from the command line, on every supported kind of log."""

from __future__ import annotations

import csv
import gzip
import json
import math
from pathlib import Path

import pytest

from tools.cli import main
from tools.logs.carmen import read_carmen

FIRST, COUNT = 27, 50


@pytest.fixture(scope="module")
def source(data_folder: Path) -> Path:
    return data_folder / "logs" / "seattle-corrected.log.gz"


def front_laser_log(source: Path, beams: int, *, stamped: bool = True) -> str:
    """Return a real log's FLASER and ODOM lines with fewer beams; unstamped: all times are 0."""
    chosen = {180: slice(0, 360, 2), 181: slice(0, 361, 2), 360: slice(0, 360), 361: slice(0, 361)}
    lines, scans = [], 0
    for line in gzip.decompress(source.read_bytes()).decode().splitlines():
        words = line.split()
        if words[:1] == ["FLASER"]:
            scans += 1
            words = ["FLASER", str(beams), *words[2:363][chosen[beams]], *words[363:]]
        elif words[:1] != ["ODOM"]:
            continue
        if not stamped:
            words[-1] = words[-3] = "0"
        if scans > FIRST:
            lines.append(" ".join(words))
        if scans == FIRST + COUNT:
            break
    return "\n".join(lines) + "\n"


def robot_laser_log(source: Path) -> str:
    """Return ROBOTLASER1 lines with raw odometry as the robot's pose, without ODOM lines."""
    lines = []
    for scan in read_carmen(source).scans[FIRST : FIRST + COUNT]:
        ranges = [f"{r:.3f}" if math.isfinite(r) else "81.9" for r in scan.ranges]
        poses = [f"{value:.6f}" for value in (*scan.reference, *scan.odometry)]
        lines.append(
            f"ROBOTLASER1 0 {scan.angle_min:.6f} {math.pi:.6f} {scan.angle_increment:.9f} 81.9 "
            f"0.01 0 {len(ranges)} {' '.join(ranges)} 0 {' '.join(poses)} "
            f"0 0 0 0 0 {scan.t:.3f} host {scan.t:.3f}"
        )
    return "\n".join(lines) + "\n"


def localize(tmp_path: Path, *words: str) -> dict:
    assert main(["localize", *words, "--json", str(tmp_path / "out.json")]) == 0
    return json.loads((tmp_path / "out.json").read_text())


@pytest.mark.parametrize("beams", [180, 181, 360, 361])
def test_front_laser_log_of_any_beam_count_is_localized(
    source: Path, tmp_path: Path, beams: int
) -> None:
    log = tmp_path / "x.log"
    log.write_text(front_laser_log(source, beams))
    summary = localize(tmp_path, "--map-from", "all", str(log))
    assert summary["scans"] == COUNT
    assert summary["position_m"]["rmse"] < 0.03
    assert summary["lost_share"] == 0.0


def test_robot_laser_log_is_localized(source: Path, tmp_path: Path) -> None:
    log = tmp_path / "x.log"
    log.write_text(robot_laser_log(source))
    summary = localize(tmp_path, "--map-from", "all", str(log))
    assert summary["scans"] == COUNT
    assert summary["position_m"]["rmse"] < 0.03


def test_log_with_zero_time_stamps_is_localized(source: Path, tmp_path: Path) -> None:
    log = tmp_path / "x.log"
    log.write_text(front_laser_log(source, 361, stamped=False))
    summary = localize(tmp_path, "--map-from", "all", str(log))
    assert summary["position_m"]["rmse"] < 0.03
    assert summary["lost_share"] == 0.0


def test_every_second_scan_is_held_out(source: Path, tmp_path: Path) -> None:
    table = tmp_path / "out.csv"
    summary = localize(tmp_path, "--map-from", "even", f"{source}:28", "--csv", str(table))
    scans = read_carmen(source).scans
    with table.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["t"]) for row in rows] == [scan.t for scan in scans[29::2]]
    assert summary["scans"] == len(rows)
    assert summary["map"] == "seattle-corrected.log.gz (even scans)"
    assert summary["position_m"]["rmse"] < 0.04
    needed = {"t", "x", "y", "theta", "cov_xx", "cov_xy", "cov_thetatheta", "particles", "health"}
    assert needed | {"reference_x", "position_error_m", "heading_error_deg"} <= set(rows[0])


def test_kidnapped_robot_and_unknown_start_are_localized(source: Path, tmp_path: Path) -> None:
    words = ("--map-from", "all", f"{source}:27")
    kidnapped = localize(tmp_path, *words, "--kidnap", "200", "--seed", "1")["after_event"]
    assert kidnapped["doubted_after_m"] <= 2.0
    assert kidnapped["right_and_localized_after_m"] <= 20.0
    anywhere = localize(tmp_path, *words, "--global")["after_event"]
    assert anywhere["right_and_localized_after_m"] <= 15.0
    assert anywhere["wrong_and_localized_scans"] == 0
    assert "after_event" not in localize(tmp_path, *words)


def test_particles_option_fixes_their_number(source: Path, tmp_path: Path) -> None:
    words = ("--map-from", "all", f"{source}:200", "--particles", "700", "--beams", "40")
    assert localize(tmp_path, *words)["particles"]["median"] == 700


def test_study_prints_a_table(
    source: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    tables = localize(tmp_path, "--study", "accuracy", "--seeds", "2", f"{source}:27")
    (row,) = tables["accuracy"]
    assert row["seeds"] == 2
    assert row["worst_rmse_m"] < 0.022
    out = capsys.readouterr().out.splitlines()
    assert out[0] == "accuracy"
    assert out[2].split()[0] == "seattle"


def test_unusable_input_is_one_error_naming_it(
    source: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for words, complaint in (
        (["--map-from", "all", f"{source}:9999"], "no scan from scan 9999"),
        (["--map-from", "all", str(source), str(source)], "2 logs"),
        (["--map-from", "all", str(tmp_path / "none.log")], "cannot be read"),
        (["--map-from", "all", str(tmp_path / "none.mcap")], "--map DIR"),
    ):
        assert main(["localize", *words]) == 1
        assert complaint in capsys.readouterr().err
