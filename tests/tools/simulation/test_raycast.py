"""Ray casting against a slow walk along each ray."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from maps.occupancy_map import FREE, OCCUPIED, UNKNOWN, OccupancyMap
from maps.pose import Pose
from tools.simulation.raycast import RayCaster
from tools.simulation.raycast import cast_bodies as cast_polygons
from tools.simulation.silhouette import middles_of, shapes_of, silhouette_of

RESOLUTION = 0.05


@pytest.fixture(scope="module")
def clutter() -> OccupancyMap:
    """A 10 x 8 m hall with walls, pillars and single occupied cells."""
    rng = np.random.default_rng(1)
    cells = np.full((160, 200), FREE, dtype=np.uint8)
    cells[[0, -1], :] = OCCUPIED
    cells[:, [0, -1]] = OCCUPIED
    for _ in range(25):
        row, col = rng.integers(5, 150), rng.integers(5, 190)
        cells[row : row + rng.integers(1, 8), col : col + rng.integers(1, 8)] = OCCUPIED
    return OccupancyMap(cells=cells, resolution=RESOLUTION, origin=Pose(-1.0, -2.0, 0.0))


def walked(occupancy: OccupancyMap, x: float, y: float, angle: float, max_range: float) -> float:
    """Return the range found by walking in steps of a tenth of a millimetre."""
    ways = np.arange(0.0, max_range, 1e-4)
    points = np.column_stack((x + ways * math.cos(angle), y + ways * math.sin(angle)))
    rows, cols = occupancy.cells_at(points)
    inside = occupancy.inside(rows, cols)
    met = np.zeros(len(ways), dtype=bool)
    met[inside] = occupancy.cells[rows[inside], cols[inside]] == OCCUPIED
    return float(ways[met.argmax()]) if met.any() else math.inf


def test_ranges_equal_a_fine_walk_along_the_ray(clutter: OccupancyMap) -> None:
    rng = np.random.default_rng(2)
    caster = RayCaster(clutter)
    for _ in range(12):
        x, y = rng.uniform((-0.9, -1.9), (8.9, 5.9))
        angles = rng.uniform(-math.pi, math.pi, 25)
        ranges = caster.cast(x, y, angles, 30.0)
        expected = [walked(clutter, x, y, angle, 30.0) for angle in angles]
        # A walk in steps may cut a cell's corner that the exact ray meets.
        differences = np.abs(ranges - expected)
        assert np.sort(differences)[-2] < 3e-4
        assert (ranges <= np.array(expected) + 1e-6).all()


@pytest.mark.parametrize("angle", [0.0, math.pi / 2, math.pi, -math.pi / 2])
def test_rays_along_the_axes_hit_walls(clutter: OccupancyMap, angle: float) -> None:
    [distance] = RayCaster(clutter).cast(4.0, 2.0, np.array([angle]), 30.0)
    assert distance == pytest.approx(walked(clutter, 4.0, 2.0, angle, 30.0), abs=3e-4)


def test_ranges_are_infinite_beyond_the_limit_and_outside_the_map() -> None:
    cells = np.full((20, 20), FREE, dtype=np.uint8)
    cells[:, 15] = OCCUPIED
    cells[:, 10] = UNKNOWN
    caster = RayCaster(OccupancyMap(cells=cells, resolution=0.1, origin=Pose(0.0, 0.0, 0.0)))
    ahead, back = np.array([0.0]), np.array([math.pi])
    assert caster.cast(0.5, 1.0, ahead, 5.0) == pytest.approx([1.0], abs=1e-5)
    assert caster.cast(0.5, 1.0, ahead, 0.9) == [math.inf]
    assert caster.cast(0.5, 1.0, back, 5.0) == [math.inf]
    assert caster.cast(-3.0, 1.0, ahead, 50.0) == [math.inf]
    assert caster.cast(1.55, 1.0, ahead, 5.0) == [0.0]


def test_an_empty_map_returns_nothing() -> None:
    cells = np.full((20, 30), FREE, dtype=np.uint8)
    caster = RayCaster(OccupancyMap(cells=cells, resolution=0.1, origin=Pose(0.0, 0.0, 0.0)))
    assert np.isinf(caster.cast(1.0, 1.0, np.linspace(-3.0, 3.0, 50), 30.0)).all()


def test_each_ray_may_have_its_own_origin(clutter: OccupancyMap) -> None:
    caster = RayCaster(clutter)
    x, y = np.array([1.0, 4.0, 6.5]), np.array([0.0, 2.0, 1.5])
    angles = np.array([0.3, -2.0, 1.2])
    together = caster.cast(x, y, angles, 30.0)
    alone = [caster.cast(*ray, 30.0)[0] for ray in zip(x, y, angles[:, None], strict=True)]
    assert together.tolist() == alone


def cast_bodies(
    x: float,
    y: float,
    angles: NDArray[np.float64],
    rectangles: NDArray[np.float64],
    max_range: float,
) -> NDArray[np.float64]:
    """Cast to rectangles (m, 5): centre x, centre y, theta, half length, half width."""
    silhouettes = [
        (silhouette_of([(a, -b), (a, b), (-a, b), (-a, -b)]),) for *_, a, b in rectangles.tolist()
    ]
    poses = [Pose(*row[:3]) for row in rectangles.tolist()]
    middles = middles_of(silhouettes, poses)
    return cast_polygons(x, y, angles, middles, shapes_of(silhouettes), max_range)


def first_crossing(corners: NDArray[np.float64], angle: float) -> float:
    """Intersect the ray from the origin with every side, one after another."""
    ray = np.array((math.cos(angle), math.sin(angle)))
    found = math.inf
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        along, share = np.linalg.solve(np.column_stack((ray, a - b)), a)
        if along >= 0.0 and 0.0 <= share <= 1.0:
            found = min(found, float(along))
    return found


def test_rays_to_polygons_end_where_they_cross_a_side() -> None:
    rng = np.random.default_rng(4)
    bodies, poses, outlines = [], [], []
    for number in range(12):
        bearings = np.sort((np.arange(3 + number % 6) + rng.uniform(0.0, 0.5)) / (3 + number % 6))
        ring = 0.3 * np.column_stack((np.cos(math.tau * bearings), np.sin(math.tau * bearings)))
        pose = Pose(rng.uniform(0.5, 4.0), rng.uniform(-3.0, 3.0), rng.uniform(-3.0, 3.0))
        c, s = math.cos(pose.theta), math.sin(pose.theta)
        bodies.append((silhouette_of(ring.tolist()),))
        poses.append(pose)
        outlines.append(ring @ np.array(((c, s), (-s, c))) + pose[:2])
    angles = rng.uniform(-math.pi, math.pi, 500)
    cast = cast_polygons(0.0, 0.0, angles, middles_of(bodies, poses), shapes_of(bodies), 30.0)
    expected = [min(first_crossing(each, angle) for each in outlines) for angle in angles]
    assert np.isfinite(cast).sum() > 50
    assert cast == pytest.approx(expected, abs=1e-9)


def test_a_ray_passes_all_parts_of_the_body_it_starts_from() -> None:
    square = silhouette_of([(0.1, -0.1), (0.1, 0.1), (-0.1, 0.1), (-0.1, -0.1)])
    mast = silhouette_of([(0.4, -0.1), (0.4, 0.1), (0.3, 0.1), (0.3, -0.1)])
    bodies, poses = [(square, mast), (square,)], [Pose(0.0, 0.0, 0.0), Pose(2.0, 0.0, 0.0)]
    table = middles_of(bodies, poses), shapes_of(bodies)
    ahead = np.array([0.0])
    assert cast_polygons(0.0, 0.0, ahead, *table, 9.0, np.array([0])) == pytest.approx([1.9])
    assert cast_polygons(2.0, 0.0, ahead + math.pi, *table, 9.0, np.array([1])) == pytest.approx(
        [1.6]
    )


def rectangle(x: float, y: float, theta: float) -> NDArray[np.float64]:
    return np.array([(x, y, theta, 0.3, 0.2)])


def test_rays_hit_rectangles_on_their_sides() -> None:
    rays = np.radians([0.0, 180.0, 20.0])
    assert cast_bodies(0.0, 0.0, rays, rectangle(2.0, 0.0, 0.0), 10.0) == pytest.approx(
        [1.7, math.inf, math.inf]
    )
    assert cast_bodies(0.0, 0.0, rays, rectangle(2.0, 0.0, math.pi / 2), 10.0) == pytest.approx(
        [1.8, math.inf, math.inf]
    )


def test_ray_hits_a_turned_rectangle_at_its_corner() -> None:
    half = math.sqrt(0.5)
    corner_x, corner_y = 2.0 - half * (0.3 + 0.2), -half * (0.3 - 0.2)
    towards = np.array([math.atan2(corner_y, corner_x)])
    [distance] = cast_bodies(0.0, 0.0, towards, rectangle(2.0, 0.0, math.pi / 4), 10.0)
    assert distance == pytest.approx(math.hypot(corner_x, corner_y), abs=1e-6)


def test_the_nearest_rectangle_counts_and_the_range_ends() -> None:
    both = np.concatenate((rectangle(3.0, 0.0, 0.0), rectangle(2.0, 0.0, 0.0)))
    ahead = np.array([0.0])
    assert cast_bodies(0.0, 0.0, ahead, both, 10.0) == pytest.approx([1.7])
    assert cast_bodies(0.0, 0.0, ahead, both, 1.0) == [math.inf]
    assert cast_bodies(2.0, 0.0, ahead, both, 10.0) == [0.0]
    assert cast_bodies(0.0, 0.0, ahead, both[:0], 10.0) == [math.inf]


def test_rays_along_a_side_pass_or_hit_the_rectangle() -> None:
    ahead = np.array([0.0])
    assert cast_bodies(0.0, 0.199, ahead, rectangle(2.0, 0.0, 0.0), 10.0) == pytest.approx([1.7])
    assert cast_bodies(0.0, 0.201, ahead, rectangle(2.0, 0.0, 0.0), 10.0) == [math.inf]


@pytest.mark.parametrize("angle", [0.0, math.pi / 2, math.pi, -math.pi, -math.pi / 2, 1e-12])
def test_rays_along_cell_sides_terminate(angle: float) -> None:
    cells = np.full((64, 64), FREE, dtype=np.uint8)
    cells[[0, -1], :] = OCCUPIED
    cells[:, [0, -1]] = OCCUPIED
    caster = RayCaster(OccupancyMap(cells=cells, resolution=0.125, origin=Pose(0.0, 0.0, 0.0)))
    [distance] = caster.cast(4.0, 4.0, np.array([angle]), 30.0)
    assert distance == pytest.approx(4.0 - 0.125, abs=1e-5)
