"""Surface normals, point-to-line alignment and exhaustive search."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from maps.pose import Pose
from robot_agent.perception.scan_points import move_points
from tools.mapping.slam import correlation
from tools.mapping.slam.alignment import align
from tools.mapping.slam.cloud import Cloud
from tools.mapping.slam.correlation import search
from tools.mapping.slam.keyframe import surface_normals


def wall(start: tuple[float, float], end: tuple[float, float]) -> NDArray[np.float64]:
    """Return points each 0.1 m with noise of 5 mm."""
    n = round(math.dist(start, end) / 0.1)
    points = np.linspace(start, end, n, endpoint=False)
    return points + np.random.default_rng(n).normal(0.0, 0.005, points.shape)


CORRIDOR = np.concatenate([wall((-4.0, -1.0), (4.0, -1.0)), wall((4.0, 1.0), (-4.0, 1.0))])
ROOM = np.concatenate(
    [
        wall((-3.0, -2.0), (4.0, -2.0)),
        wall((4.0, -2.0), (4.0, 1.0)),
        wall((4.0, 1.0), (1.0, 1.0)),
        wall((1.0, 1.0), (1.0, 3.0)),
    ]
)


def cloud(points: NDArray[np.float64]) -> Cloud:
    return Cloud(points, surface_normals(points))


def seen_from(points: NDArray[np.float64], pose: Pose) -> NDArray[np.float64]:
    return move_points(points, pose.inverse())


def test_normals_are_perpendicular_to_walls_and_missing_at_corners() -> None:
    normals = surface_normals(ROOM)
    along_x = (abs(ROOM[:, 1] + 2.0) < 0.1) & (ROOM[:, 0] < 3.5)
    assert np.abs(normals[along_x, 1]).min() > 0.98
    corner = int(np.argmin(np.hypot(ROOM[:, 0] - 4.0, ROOM[:, 1] + 2.0)))
    assert np.isnan(normals[corner]).all()
    assert np.isnan(surface_normals(np.array([[0.0, 0.0], [5.0, 0.0], [0.0, 5.0]]))).all()
    assert surface_normals(np.empty((0, 2))).shape == (0, 2)


def test_alignment_finds_the_pose_in_a_room() -> None:
    truth = Pose(0.25, -0.15, math.radians(6.0))
    found = align(seen_from(ROOM, truth), cloud(ROOM), Pose(0.0, 0.0, 0.0))
    assert found is not None
    assert found.pose == pytest.approx(truth, abs=0.003)
    assert found.share > 0.95
    assert np.linalg.eigvalsh(found.information).min() > 1000.0


def test_corridor_gives_no_information_along_it() -> None:
    truth = Pose(0.3, 0.1, math.radians(2.0))
    found = align(seen_from(CORRIDOR, truth), cloud(CORRIDOR), Pose(0.0, 0.0, 0.0))
    assert found is not None
    assert found.pose.y == pytest.approx(0.1, abs=0.003)
    assert found.pose.theta == pytest.approx(truth.theta, abs=0.003)
    assert found.pose.x == pytest.approx(0.0, abs=0.02), "stays where it was thought"
    along = np.array([1.0, 0.0, 0.0])
    assert along @ found.information @ along < 100.0
    assert found.information[1, 1] > 1000.0


def test_alignment_without_counterparts_is_none() -> None:
    assert align(ROOM + 50.0, cloud(ROOM), Pose(0.0, 0.0, 0.0)) is None
    assert align(ROOM, cloud(np.zeros((3, 2))), Pose(0.0, 0.0, 0.0)) is None


def test_search_finds_a_pose_beyond_the_reach_of_alignment() -> None:
    truth = Pose(1.7, -1.2, math.radians(25.0))
    scan = seen_from(ROOM, truth)
    peak = search(scan, ROOM, Pose(0.0, 0.0, 0.0), 2.0, math.radians(30.0))
    assert math.dist(peak.pose[:2], truth[:2]) < 0.15
    assert abs(peak.pose.theta - truth.theta) < math.radians(2.0)
    assert peak.score > 0.8
    assert peak.runner_up < 0.9 * peak.score


@pytest.mark.parametrize("window", [0.0, 0.2, 0.5, 2.0])
def test_scores_looked_up_are_those_of_the_convolution(
    window: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    scan = seen_from(ROOM, Pose(0.15, -0.1, math.radians(7.0)))
    arguments = (scan, ROOM, Pose(0.0, 0.0, 0.0), window, math.radians(10.0))
    looked_up = search(*arguments)
    monkeypatch.setattr(correlation, "_LOOKED_UP", -1)
    convolved = search(*arguments)
    assert looked_up.pose == convolved.pose
    assert looked_up.score == pytest.approx(convolved.score, abs=1e-5)
    assert looked_up.runner_up == pytest.approx(convolved.runner_up, abs=1e-5)


def test_runner_up_score_is_high_when_places_are_alike() -> None:
    peak = search(CORRIDOR, CORRIDOR, Pose(0.0, 0.0, 0.0), 2.0, math.radians(10.0))
    assert peak.runner_up > 0.85 * peak.score
    assert peak.pose == pytest.approx((0.0, 0.0, 0.0), abs=0.11), "the nearest is preferred"
