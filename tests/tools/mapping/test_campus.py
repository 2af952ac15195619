"""An outdoor log: most beams see nothing, and no map of it may be called good."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from maps.pose import Pose
from tools.cli import main

GROUND = (100.0, 70.0)  # m; open, with the corners of three buildings and thin trunks
CORNERS = [(-20.0, -20.0, 6.0, 4.0), (95.0, 64.0, 120.0, 90.0), (45.0, 32.0, 55.0, 40.0)]
WAY = [(12.0, 9.0), (88.0, 10.0), (88.0, 58.0), (14.0, 60.0), (12.0, 9.0), (40.0, 10.0)]
STEP = 4.0  # m between scans
REACH = 30.0  # m
NOTHING = 81.91  # m; what the scanner says where nothing returns


def test_map_of_a_campus_is_not_called_good(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log, folder = tmp_path / "campus.log", tmp_path / "campus"
    write_log(log, np.random.default_rng(1))
    main(["map", "build", str(log), "-o", str(folder), "--from", "odometry"])
    said = capsys.readouterr().out
    assert "campus: good" not in said
    assert "campus: doubtful: " in said or "campus: failed: " in said
    assert "rest on odometry alone" in said
    assert (folder / "map.png").exists()


def write_log(path: Path, rng: np.random.Generator) -> None:
    """Write a CARMEN log of raw odometry that drifts."""
    trunks = trunks_beside_the_way(rng)
    odometry, last, lines = Pose(*WAY[0], 0.0), Pose(*WAY[0], 0.0), []
    for number, pose in enumerate(poses_along_the_way()):
        step = last.between(pose)
        counted = 1.0 + 0.05 * float(rng.standard_normal())
        drift = 0.003 * step.x + 0.01 * float(rng.standard_normal())
        odometry = odometry.compose(Pose(counted * step.x, step.y, step.theta + drift))
        last = pose
        ranges = scan(pose, trunks, rng)
        place = f"{odometry.x:.6f} {odometry.y:.6f} {odometry.theta:.6f}"
        readings = " ".join(f"{value:.2f}" for value in ranges)
        t = f"{5.0 * number:.3f}"
        lines.append(f"FLASER {len(ranges)} {readings} {place} {place} {t} host {t}\n")
    path.write_text("".join(lines))


def poses_along_the_way() -> Iterator[Pose]:
    for (x1, y1), (x2, y2) in pairwise(WAY):
        length, heading = math.hypot(x2 - x1, y2 - y1), math.atan2(y2 - y1, x2 - x1)
        for along in np.arange(0.0, length, STEP):
            yield Pose(x1 + along * math.cos(heading), y1 + along * math.sin(heading), heading)


def trunks_beside_the_way(rng: np.random.Generator) -> np.ndarray:
    """Return (n, 3) x, y and radius of tree trunks, m, none within 2 m of the way."""
    way = np.array([pose[:2] for pose in poses_along_the_way()])
    places = rng.uniform((0.0, 0.0), GROUND, (40, 2))
    apart = np.linalg.norm(places[:, np.newaxis] - way, axis=2).min(axis=1)
    return np.column_stack((places, rng.uniform(0.1, 0.25, 40)))[apart > 2.0]


def scan(pose: Pose, trunks: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return 180 ranges, m, over the half turn ahead."""
    angles = pose.theta + np.radians(np.arange(180) - 90.0)
    ux, uy = np.cos(angles)[:, np.newaxis], np.sin(angles)[:, np.newaxis]
    # 1. The trunks, circles.
    away_x, away_y, radius = trunks[:, 0] - pose.x, trunks[:, 1] - pose.y, trunks[:, 2]
    ahead, aside = away_x * ux + away_y * uy, away_x * uy - away_y * ux
    half = np.sqrt(np.maximum(radius**2 - aside**2, 0.0))
    seen = np.where((ahead > 0.0) & (np.abs(aside) < radius), ahead - half, np.inf).min(axis=1)
    # 2. The buildings, boxes.
    for low_x, low_y, high_x, high_y in CORNERS:
        with np.errstate(divide="ignore"):
            to_x = np.sort(np.hstack(((low_x - pose.x) / ux, (high_x - pose.x) / ux)))
            to_y = np.sort(np.hstack(((low_y - pose.y) / uy, (high_y - pose.y) / uy)))
        enter, leave = np.maximum(to_x[:, 0], to_y[:, 0]), np.minimum(to_x[:, 1], to_y[:, 1])
        seen = np.minimum(seen, np.where((enter < leave) & (enter > 0.0), enter, np.inf))
    noisy = seen + 0.01 * rng.standard_normal(len(seen))
    return np.where(noisy > REACH, NOTHING, noisy)
