"""Scan-to-map refinement: finds the true pose, or rejects the refinement."""

from __future__ import annotations

import math

import numpy as np
import pytest

from localization.distance_surface import DistanceSurface
from localization.refinement import Refinement
from maps.occupancy_map import OCCUPIED, OccupancyMap, Surface
from maps.pose import Pose

TRUTH = Pose(3.0, 2.0, 0.4)
CLOUD = np.diag([0.05**2, 0.05**2, 0.03**2])


def test_surface_gradient_is_that_of_its_values() -> None:
    rng = np.random.default_rng(1)
    cells = (rng.random((30, 40)) < 0.05).astype(np.uint8)
    surface = DistanceSurface(OccupancyMap(cells, 0.1, Pose(-1, 3, 0)))
    places = (rng.uniform(0, 2.5, 50) + 1j * rng.uniform(0, 2.5, 50)).astype(np.complex64)
    here = Pose(-0.9, 3.1, 0)
    slope_x, slope_y, distance = surface.sample(here, places)
    step = 1e-3
    east = surface.sample(Pose(here.x + step, here.y, 0), places)[2]
    north = surface.sample(Pose(here.x, here.y + step, 0), places)[2]
    # A place within a step of a cell's edge has another slope on the other side.
    assert np.median(np.abs((east - distance) / step - slope_x)) < 1e-2
    assert np.median(np.abs((north - distance) / step - slope_y)) < 1e-2


def test_surface_is_the_distance_field_at_cell_centres_and_far_outside() -> None:
    cells = np.zeros((5, 6), dtype=np.uint8)
    cells[2, 3] = OCCUPIED
    occupancy = OccupancyMap(cells, 0.2, Pose(10.0, -4.0, 0.0), Surface.CENTRE)
    surface = DistanceSurface(occupancy)
    rows, cols = np.divmod(np.arange(30), 6)
    centres = ((cols + 0.5) * 0.2 + 1j * (rows + 0.5) * 0.2).astype(np.complex64)
    distance = surface.sample(Pose(10.0, -4.0, 0.0), centres)[2]
    expected = np.minimum(occupancy.distance_field().ravel(), 0.45)
    assert distance == pytest.approx(expected, abs=1e-4)
    outside = np.array([100 + 100j, -100 - 100j], dtype=np.complex64)
    assert surface.sample(Pose(10, -4, 0), outside)[2] == pytest.approx([0.45, 0.45], abs=2e-3)


@pytest.mark.parametrize(
    "off", [(0.08, -0.05, 0.03), (-0.1, 0.0, -0.04), (0.0, 0.1, 0.05), (0.03, 0.03, -0.06)]
)
def test_refines_to_the_true_pose(room, off: tuple[float, float, float]) -> None:
    points = room.scan(TRUTH, np.random.default_rng(1))
    start = Pose(TRUTH.x + off[0], TRUTH.y + off[1], TRUTH.theta + off[2])
    refined = Refinement(room.map).refine(start, CLOUD, points)
    assert refined is not None
    pose = refined.pose
    assert math.hypot(pose.x - TRUTH.x, pose.y - TRUTH.y) < 0.02
    assert abs(pose.theta - TRUTH.theta) < math.radians(0.5)


def test_people_have_no_influence(room) -> None:
    rng = np.random.default_rng(2)
    points = room.scan(TRUTH, rng)
    points[60:100] *= 0.4
    start = Pose(TRUTH.x + 0.06, TRUTH.y - 0.04, TRUTH.theta + 0.02)
    refined = Refinement(room.map).refine(start, CLOUD, points)
    assert refined is not None
    pose = refined.pose
    assert math.hypot(pose.x - TRUTH.x, pose.y - TRUTH.y) < 0.03


def test_refinement_beyond_the_limits_is_rejected(room) -> None:
    """From any pose nearby, with any scan: either rejected or within the limits."""
    refinement = Refinement(room.map, limit_xy=0.15, limit_theta=0.08)
    rng = np.random.default_rng(3)
    accepted = 0
    for _ in range(300):
        pose = Pose(*rng.uniform((0.5, 0.5, -3), (6, 4.5, 3)))
        off = rng.normal(0, (0.3, 0.3, 0.3))
        start = Pose(pose.x + off[0], pose.y + off[1], pose.theta + off[2])
        spread = rng.uniform(0.01, 0.5)
        refined = refinement.refine(start, np.eye(3) * spread**2, room.scan(pose, rng))
        if refined is not None:
            accepted += 1
            moved = refined.pose
            assert math.hypot(moved.x - start.x, moved.y - start.y) <= 0.15
            turn = math.remainder(moved.theta - start.theta, math.tau)
            assert abs(turn) <= 0.08 + 1e-9
    assert 0 < accepted < 300


def test_in_a_bare_corridor_the_position_along_it_is_kept() -> None:
    cells = np.zeros((60, 400), dtype=np.uint8)
    cells[[10, 50], :] = OCCUPIED
    corridor = OccupancyMap(cells, 0.05, Pose(0, 0, 0), Surface.CENTRE)
    along = np.linspace(-4, 4, 90)
    walls = np.vstack(
        (np.column_stack((along, np.full(90, 1.0))), np.column_stack((along, np.full(90, -1.0))))
    )
    truth = Pose(10.0, 1.525, 0.0)
    start = Pose(truth.x + 0.1, truth.y + 0.08, 0.03)
    refined = Refinement(corridor).refine(start, CLOUD, walls)
    assert refined is not None
    assert refined.pose.y == pytest.approx(truth.y, abs=0.01)
    assert refined.pose.theta == pytest.approx(0.0, abs=0.005)
    assert refined.pose.x == pytest.approx(start.x, abs=0.01)
    sigma_x, sigma_y, _ = np.sqrt(np.diag(refined.covariance))
    assert sigma_x >= 0.05  # along the corridor the variance is not below that of the cloud
    assert sigma_y < 0.02


def test_too_few_points_give_none(room) -> None:
    refinement = Refinement(room.map)
    points = room.scan(TRUTH)[:9]
    assert refinement.refine(TRUTH, CLOUD, points) is None


def test_stated_covariance_is_symmetric_and_grows_where_the_map_is_blurred(room) -> None:
    """The end points' own residual measures their error."""
    refinement = Refinement(room.map)
    sharp, blurred = (
        refinement.refine(
            Pose(TRUTH.x + 0.05, TRUTH.y, TRUTH.theta),
            CLOUD,
            room.scan(TRUTH, np.random.default_rng(1), sigma=sigma),
        )
        for sigma in (0.01, 0.08)
    )
    assert sharp is not None
    assert blurred is not None
    assert np.array_equal(sharp.covariance, sharp.covariance.T)
    assert np.linalg.eigvalsh(sharp.covariance).min() > 0.0
    assert np.trace(blurred.covariance) > 2.0 * np.trace(sharp.covariance)
