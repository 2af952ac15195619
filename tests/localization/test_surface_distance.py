"""Distance from the mapped surface: on the faces of drawn walls, in the cells of scanned ones."""

from __future__ import annotations

import numpy as np
import pytest

from localization.distance_surface import DistanceSurface
from localization.refinement import Refinement
from localization.surface_distance import FAR, surface_distance
from maps.occupancy_map import OCCUPIED, OccupancyMap, Surface
from maps.pose import Pose

CELL = 0.1


def walls(thickness: int, surface: Surface = Surface.FACE) -> OccupancyMap:
    """A square room of 4 m between walls of so many cells, its lower-left inner corner at 0, 0."""
    cells = np.full((40 + 2 * thickness,) * 2, OCCUPIED, dtype=np.uint8)
    cells[thickness:-thickness, thickness:-thickness] = 0
    return OccupancyMap(cells, CELL, Pose(-thickness * CELL, -thickness * CELL, 0.0), surface)


def test_distance_of_a_drawn_map_equals_brute_force_to_the_cells_squares() -> None:
    rng = np.random.default_rng(1)
    cells = (rng.random((9, 13)) < 0.2).astype(np.uint8)
    found = surface_distance(cells, CELL, Surface.FACE)
    for row, col in np.ndindex(cells.shape):
        others = np.argwhere((cells == OCCUPIED) != (cells[row, col] == OCCUPIED))
        outside = np.maximum(np.abs(others - (row, col)) - 0.5, 0.0)
        distance = CELL * np.hypot(*outside.T).min()
        sign = -1.0 if cells[row, col] == OCCUPIED else 1.0
        assert found[row, col] == pytest.approx(sign * min(distance, FAR), abs=1e-6)


@pytest.mark.parametrize("thickness", [1, 2, 5])
def test_zero_level_of_a_drawn_wall_is_its_face_and_crossed_at_full_slope(thickness: int) -> None:
    surface = DistanceSurface(walls(thickness))
    places = np.array([-0.03, 0.0, 0.03, 0.2]) + 2.0j
    slope, _, distance = surface.sample(Pose(0.0, 0.0, 0.0), places.astype(np.complex64))
    assert distance == pytest.approx([-0.03, 0.0, 0.03, 0.2], abs=1e-4)
    assert slope == pytest.approx(np.ones(4), abs=2e-3)


@pytest.mark.parametrize("thickness", [1, 2, 5])
def test_pose_before_a_drawn_wall_is_refined_without_bias(thickness: int) -> None:
    along = np.linspace(-0.9, 0.9, 60)
    ahead = np.column_stack((np.full(60, 1.0), along))
    left = np.column_stack((along, np.full(60, 1.0)))
    truth = Pose(3.0, 3.0, 0.0)
    start = Pose(2.97, 3.03, 0.02)
    cloud = np.diag([0.2**2, 0.2**2, 0.1**2])
    refined = Refinement(walls(thickness)).refine(start, cloud, np.vstack((ahead, left)))
    assert refined is not None
    assert list(refined.pose) == pytest.approx(list(truth), abs=0.004)


def test_surface_of_a_scanned_map_is_the_middle_of_its_cells() -> None:
    occupancy = walls(1, Surface.CENTRE)
    found = surface_distance(occupancy.cells, CELL, Surface.CENTRE)
    np.testing.assert_allclose(found, np.minimum(occupancy.distance_field(), FAR), atol=1e-6)


@pytest.mark.parametrize("resolution", [0.002, 0.01, 0.05, 0.1, 0.5])
def test_distances_of_any_resolution_are_those_to_the_nearest_cell(resolution: float) -> None:
    cells = np.zeros((70, 90), dtype=np.uint8)
    cells[20, 30] = cells[60, 5] = OCCUPIED
    expected = OccupancyMap(cells, resolution, Pose(0, 0, 0)).distance_field()
    found = surface_distance(cells, resolution, Surface.CENTRE)
    np.testing.assert_allclose(found, np.minimum(expected, FAR), atol=1e-6)


def test_map_without_walls_or_without_floor_has_no_surface() -> None:
    bare, full = (
        surface_distance(np.full((3, 4), state, np.uint8), CELL, Surface.FACE) for state in (0, 1)
    )
    assert (bare == np.float32(FAR)).all()
    assert (full == np.float32(-FAR)).all()
