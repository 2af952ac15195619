"""Maps from raw odometry: a simulated building with a loop, and the start of a real log."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from maps.map_folder import MapFolder, load_map_folder
from maps.occupancy_map import save_map
from maps.pose import Pose, wrap_angle
from tools.cli import main
from tools.localize.localize import LocalizeOptions, localize_steps
from tools.logs.carmen import CarmenLog, CarmenScan, read_carmen
from tools.logs.log_step import LogStep
from tools.logs.scan_log import ScanLog, read_scan_log
from tools.mapping.map_build import build_map
from tools.mapping.slam.loop_check import MOST_STRAIN
from tools.mapping.slam.mapper import Mapping, map_from_odometry
from tools.simulation.raycast import RayCaster

PAPER_LAB = Path(__file__).resolve().parents[4] / "maps" / "paper_lab"
BEAMS = math.radians(-90.0) + math.radians(1.0) * np.arange(181)
STEP = 0.5  # m between scans
REACH = 15.0  # m of the simulated laser


def true_poses(folder: MapFolder) -> list[Pose]:
    """Return poses once round the border and again over its first part."""
    assert folder.border is not None
    way = np.arange(0.0, folder.border.length + 8.0, STEP)
    points = [folder.border.at(float(s % folder.border.length)) for s in way]
    return [Pose(p.x, p.y, math.atan2(p.ty, p.tx)) for p in points]


def drifted(truth: list[Pose], rng: np.random.Generator) -> list[Pose]:
    """Return odometry that turns 2 degrees too far per metre and is 2 % too long."""
    poses = [Pose(0.0, 0.0, 0.0)]
    for last, pose in itertools.pairwise(truth):
        step = last.between(pose)
        noise = rng.normal(0.0, (0.01, 0.01, math.radians(0.3)))
        poses.append(
            poses[-1].compose(
                Pose(
                    1.02 * step.x + noise[0],
                    1.02 * step.y + noise[1],
                    wrap_angle(step.theta + math.radians(2.0) * STEP + noise[2]),
                )
            )
        )
    return poses


@pytest.fixture(scope="module")
def drive() -> ScanLog:
    """Return a drive round the shipped floor plan; its references are the true poses."""
    folder = load_map_folder(PAPER_LAB)
    rng = np.random.default_rng(4)
    caster = RayCaster(folder.map)
    truth = true_poses(folder)
    scans = []
    for t, (pose, odometry) in enumerate(zip(truth, drifted(truth, rng), strict=True)):
        ranges = caster.cast(pose.x, pose.y, pose.theta + BEAMS, REACH)
        scans.append(
            CarmenScan(
                t=float(t),
                ranges=ranges + rng.normal(0.0, 0.01, ranges.shape),
                angle_min=float(BEAMS[0]),
                angle_increment=math.radians(1.0),
                reference=pose,
                odometry=odometry,
            )
        )
    knots = [(scan.t, scan.odometry) for scan in scans]
    return ScanLog(Path("simulated.log"), scans, knots, list(range(len(scans))), True, None)


@pytest.fixture(scope="module")
def mapped(drive: ScanLog) -> Mapping:
    return map_from_odometry(drive)


def distances(poses: list[Pose], truth: list[Pose]) -> list[float]:
    """Return each pose's distance from the true one, m, both relative to the first."""
    return [
        math.dist(poses[0].between(a)[:2], truth[0].between(b)[:2])
        for a, b in zip(poses, truth, strict=True)
    ]


def test_loop_closing_removes_the_drift(drive: ScanLog, mapped: Mapping) -> None:
    truth = [scan.reference for scan in drive.scans]
    before = distances([scan.odometry for scan in drive.scans], truth)
    after = distances([scan.reference for scan in mapped.log.scans], truth)
    assert max(before) > 5.0, "the odometry alone draws no map"
    assert mapped.strains
    assert max(mapped.strains) < MOST_STRAIN
    assert float(np.mean(after)) < 0.10
    assert max(after) < 0.25
    assert mapped.off_references is not None
    assert mapped.off_references < 0.06
    assert mapped.disagreement < 0.02
    assert f"{len(mapped.strains)} loops closed" in mapped.summary()


def test_references_are_not_used(drive: ScanLog, mapped: Mapping) -> None:
    elsewhere = [Pose(float(i), 0.0, 0.0) for i in range(len(drive.scans))]
    blind = map_from_odometry(replace(drive.with_references(elsewhere), referenced=False))
    assert blind.off_references is None
    found = [scan.reference for scan in blind.log.scans]
    assert found[0] == pytest.approx(drive.scans[0].odometry), "the odometry's own frame"
    assert max(distances(found, [scan.reference for scan in mapped.log.scans])) < 1e-6


def localized(log: ScanLog, folder: Path) -> dict[str, object]:
    """Localize a log's odd scans on a map of its even ones."""
    save_map(build_map(log, scans="even").map, folder)
    steps = [
        LogStep(scan.t, scan.odometry, scan.points(), scan.reference) for scan in log.scans[1::2]
    ]
    return localize_steps("odd", steps, load_map_folder(folder), LocalizeOptions()).summary


def test_localization_works_on_the_built_map(mapped: Mapping, tmp_path: Path) -> None:
    summary = localized(mapped.log, tmp_path / "made")
    assert summary["lost_share"] == 0.0
    position = summary["position_m"]
    assert isinstance(position, dict)
    assert position["p95"] < 0.15


@pytest.fixture(scope="module")
def short_log(data_folder: Path) -> ScanLog:
    """Return the first loops of a real log."""
    log = read_scan_log(data_folder / "logs" / "intel-corrected.log.gz")
    return replace(log, scans=log.scans[:150], scan_lines=log.scan_lines[:150])


def test_real_log_is_mapped_without_its_references(short_log: ScanLog, tmp_path: Path) -> None:
    odometry = distances(
        [scan.odometry for scan in short_log.scans], [scan.reference for scan in short_log.scans]
    )
    mapped = map_from_odometry(short_log)
    assert max(odometry) > 5.0
    assert mapped.off_references is not None
    assert mapped.off_references < 0.15
    summary = localized(mapped.log, tmp_path / "made")
    assert summary["lost_share"] == 0.0


def write_carmen(log: ScanLog, path: Path) -> None:
    """Write an uncorrected log: every pose in it is the raw odometry."""
    lines = []
    for scan in log.scans:
        assert isinstance(scan, CarmenScan)
        ranges = " ".join(f"{min(r, 81.9):.3f}" for r in scan.ranges)
        pose = " ".join(f"{value:.6f}" for value in scan.odometry)
        lines.append(f"FLASER {len(scan.ranges)} {ranges} {pose} {pose} {scan.t} host {scan.t}")
    path.write_text("\n".join(lines) + "\n")


def test_command_builds_from_odometry_and_prints_the_quality(
    drive: ScanLog, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    part = replace(drive, scans=drive.scans[:30], scan_lines=drive.scan_lines[:30])
    write_carmen(part, tmp_path / "raw.log")
    relations = tmp_path / "true.relations"
    first, last = part.scans[0].reference, part.scans[-1].reference
    x, y, theta = first.between(last)
    relations.write_text(f"1000.0 1029.0 {x} {y} 0 0 0 {theta}\n")
    log, made = str(tmp_path / "raw.log"), tmp_path / "made"
    judged = ("--relations", str(relations), "--relations-epoch", "1000")

    assert main(["map", "build", log, "-o", str(made), *judged]) != 0
    assert "build the map with --from odometry" in capsys.readouterr().err
    assert main(["map", "build", log, "-o", str(made), "--from", "odometry", *judged]) == 0
    found = capsys.readouterr().out
    assert "keyframes" in found
    assert "graph mapping 0.031 m" in found
    assert "off the log's own poses" not in found, "they are the odometry"
    assert mean_error(found) < 0.15
    assert load_map_folder(made).map.size[0] > 5.0
    assert (made / "map.png").read_bytes().startswith(b"\x89PNG")


def mean_error(out: str) -> float:
    return float(out.split("log): mean ")[1].split(" m")[0])


def test_command_reports_errors(
    tmp_path: Path, drive: ScanLog, capsys: pytest.CaptureFixture[str]
) -> None:
    write_carmen(drive, tmp_path / "raw.log")
    (tmp_path / "bad").write_text("1 2 3\n")
    log, made = str(tmp_path / "raw.log"), str(tmp_path / "made")
    for extra, said in (
        (("--relations", str(tmp_path / "bad")), "bad: line 1: 3 fields instead of 8"),
        (("--first-scan", "1000", "--from", "odometry"), "no scan from scan 1000 on"),
    ):
        assert main(["map", "build", log, "-o", made, *extra]) != 0
        assert said in capsys.readouterr().err


def test_a_logs_lines_keep_the_order_of_motion(data_folder: Path) -> None:
    log: CarmenLog = read_carmen(data_folder / "logs" / "intel-corrected.log.gz")
    assert [log.lines[i] for i in log.scan_lines] == [(s.t, s.odometry) for s in log.scans]
    steps = [math.dist(a[:2], b[:2]) for (_, a), (_, b) in zip(log.lines, log.lines[1:])]  # noqa: B905
    assert max(steps) < 0.35, "in the order of the stamps the robot would jump to and fro"
    assert len(log.lines) > 1.2 * len(log.odometry)
