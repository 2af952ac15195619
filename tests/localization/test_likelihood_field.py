"""The likelihood field on hand-drawn grids."""

from __future__ import annotations

import math

import numpy as np
import pytest

from localization.likelihood_field import LikelihoodField, spread_evenly
from maps.occupancy_map import OCCUPIED, UNKNOWN, OccupancyMap, Surface
from maps.pose import Pose


def field_of(occupancy: OccupancyMap) -> LikelihoodField:
    return LikelihoodField(occupancy, 60)


def one_wall() -> OccupancyMap:
    """10 x 20 cells of 0.1 m from (-1, 2); one occupied cell, its centre at (0.05, 2.55)."""
    cells = np.zeros((10, 20), dtype=np.uint8)
    cells[5, 10] = OCCUPIED
    cells[0, 0] = UNKNOWN
    return OccupancyMap(cells, 0.1, Pose(-1.0, 2.0, 0.0), Surface.CENTRE)


def log_weight(pose: tuple[float, float, float], points: list[tuple[float, float]]) -> float:
    field = field_of(one_wall())
    return float(field.log_weights(np.array([pose]), np.array(points), 1.0)[0])


def expected(distance: float) -> float:
    return math.log(0.9 * math.exp(-0.5 * (distance / 0.1) ** 2) + 0.1)


def test_end_point_on_the_wall_has_likelihood_one() -> None:
    assert log_weight((0.05, 2.55, 0.0), [(0.0, 0.0)]) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(("dx", "dy"), [(0.1, 0.0), (-0.2, 0.0), (0.0, 0.3), (0.2, -0.3)])
def test_end_point_away_from_the_wall_is_rated_by_its_distance(dx: float, dy: float) -> None:
    found = log_weight((0.05, 2.55, 0.0), [(dx, dy)])
    assert found == pytest.approx(expected(math.hypot(dx, dy)), abs=1e-3)


def test_points_turn_with_the_particle() -> None:
    """One metre ahead of a robot looking up (+y) from a metre below the wall."""
    assert log_weight((0.05, 1.55, math.pi / 2), [(1.0, 0.0)]) == pytest.approx(0.0, abs=1e-5)
    assert log_weight((0.05, 1.55, -math.pi / 2), [(1.0, 0.0)]) == pytest.approx(
        expected(9.9), abs=1e-3
    )


def test_outside_the_map_only_the_random_share_is_left() -> None:
    assert log_weight((50.0, -80.0, 0.0), [(1.0, 0.0)]) == pytest.approx(math.log(0.1), abs=1e-3)


def test_the_product_over_beams_is_tempered() -> None:
    field = field_of(one_wall())
    pose = np.array([[0.05, 2.55, 0.0]])
    beams = np.tile([[0.1, 0.0]], (30, 1))
    assert field.log_weights(pose, beams, 6.0)[0] == pytest.approx(6 * expected(0.1), rel=1e-3)
    few = field.log_weights(pose, beams[:3], 6.0)[0]
    assert few == pytest.approx(3 * expected(0.1), rel=1e-3)


def test_no_beams_give_zero_log_likelihood() -> None:
    field = field_of(one_wall())
    assert not field.log_weights(np.zeros((7, 3)), np.empty((0, 2)), 6.0).any()


def test_many_particles_give_what_each_gives_alone() -> None:
    field = field_of(one_wall())
    rng = np.random.default_rng(3)
    particles = rng.uniform((-1, 2, -3), (1, 3, 3), (4500, 3))
    points = rng.uniform(-1, 1, (40, 2))
    together = field.log_weights(particles, points, 10.0)
    for index in (0, 1999, 2000, 4499):
        alone = field.log_weights(particles[index : index + 1], points, 10.0)
        assert together[index] == pytest.approx(alone[0], rel=1e-4)


def large_map() -> OccupancyMap:
    """A map of 150 x 150 m, too large for one image, with a pillar each 2 m."""
    cells = np.zeros((3000, 3000), dtype=np.uint8)
    cells[::40, ::40] = OCCUPIED
    return OccupancyMap(cells, 0.05, Pose(-70.0, 20.0, 0.0), Surface.CENTRE)


def test_particles_all_over_a_large_map_give_what_each_gives_alone() -> None:
    field, rng = field_of(large_map()), np.random.default_rng(5)
    points = rng.uniform(-5, 5, (40, 2))
    everywhere = rng.uniform((-90, 0, -3), (100, 190, 3), (2000, 3))
    together = field.log_weights(everywhere, points, 10.0)
    alone = [field.log_weights(each[np.newaxis], points, 10.0)[0] for each in everywhere]
    assert together.max() - together.min() > 1.0
    np.testing.assert_allclose(together, alone, rtol=1e-4)


def test_particles_at_places_of_a_large_map_give_what_each_gives_alone() -> None:
    field, rng = field_of(large_map()), np.random.default_rng(5)
    points = rng.uniform(-5, 5, (40, 2))
    for x in (-200.0, 0.0, 3.0, 40.0, 78.0, 85.0):
        near = rng.normal((x, 100.0, 0.0), (0.1, 0.1, 0.1), (300, 3))
        together = field.log_weights(near, points, 10.0)
        alone = [field.log_weights(each[np.newaxis], points, 10.0)[0] for each in near]
        np.testing.assert_allclose(together, alone, rtol=1e-4)


def test_map_without_obstacles_is_accepted() -> None:
    empty = OccupancyMap(np.zeros((5, 5), dtype=np.uint8), 0.1, Pose(0, 0, 0))
    weights = field_of(empty).log_weights(np.array([[0.2, 0.2, 0.0]]), np.array([[0.1, 0.0]]), 1.0)
    assert weights == pytest.approx([math.log(0.1)], abs=1e-3)


def test_beams_are_spread_over_the_whole_scan() -> None:
    points = np.column_stack((np.arange(181), np.zeros(181)))
    chosen = spread_evenly(points, 60)
    assert len(chosen) == 60
    assert np.diff(chosen[:, 0]).max() <= 4
    assert chosen[-1, 0] >= 176
    assert spread_evenly(points, 500) is points


def test_beams_through_walls_count_less_than_those_that_end_before_them(room) -> None:
    pose = Pose(3.0, 2.0, 0.4)
    field, points = field_of(room.map), room.scan(pose)
    length = np.linalg.norm(points, axis=1, keepdims=True)
    before, behind = points * (1.0 - 0.6 / length), points * (1.0 + 0.6 / length)

    def log_weight_of(scan, **kind: bool) -> float:
        return float(field.log_weights(np.array([pose]), scan, 1.0, **kind)[0])

    assert log_weight_of(points, through_walls=True) == pytest.approx(log_weight_of(points))
    assert log_weight_of(before, through_walls=True) == pytest.approx(log_weight_of(before))
    assert log_weight_of(behind) == pytest.approx(math.log(0.1), abs=0.3)
    assert log_weight_of(behind, through_walls=True) == pytest.approx(math.log(0.01), abs=0.2)
