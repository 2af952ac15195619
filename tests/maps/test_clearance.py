"""Clearance of a border on a map."""

from __future__ import annotations

import numpy as np
import pytest

from maps.border import Border
from maps.border_primitives import Segment
from maps.clearance import NEEDED_CLEARANCE, border_clearance, needed_clearance
from maps.occupancy_map import FREE, OCCUPIED, UNKNOWN, OccupancyMap
from maps.pose import Pose

ORIGIN = Pose(-2.0, 10.0, 0.0)


def hall(wall_row: int = 0) -> np.ndarray:
    """A 4 x 3 m hall, cells of 0.05 m, with one row of wall."""
    cells = np.full((60, 80), FREE, dtype=np.uint8)
    cells[wall_row] = OCCUPIED
    return cells


def straight(x0: float, y0: float, x1: float, y1: float) -> Border:
    return Border([Segment((x0, y0), (x1, y1))], closed=False)


def test_distance_is_to_the_walls_edge() -> None:
    # The wall's cells end at y = 10.05.
    room = border_clearance(OccupancyMap(hall(), 0.05, ORIGIN), straight(-1, 11, 1, 11))
    np.testing.assert_allclose(room.distances, 0.95, atol=1e-5)
    assert room.abscissae[-1] == pytest.approx(2.0)


def test_narrowest_place_is_found() -> None:
    cells = hall()
    cells[40, 30] = OCCUPIED  # centre at x = -0.475, y = 12.025
    room = border_clearance(OccupancyMap(cells, 0.05, ORIGIN), straight(-1.5, 11.6, 1.5, 11.6))
    assert room.minimum == pytest.approx(0.4, abs=0.005)
    assert room.narrowest.x == pytest.approx(-0.475, abs=0.02)
    assert room.narrowest.abscissa == pytest.approx(1.025, abs=0.02)
    assert "y 11.60" in str(room.narrowest)
    assert room.first_occupied is None
    assert room.first_outside is None
    assert room.first_unknown is None


def test_border_through_a_wall_has_zero_clearance_and_its_place() -> None:
    room = border_clearance(OccupancyMap(hall(30), 0.05, ORIGIN), straight(0.02, 10.5, 0.02, 12.5))
    assert room.minimum == 0.0
    assert room.first_occupied is not None
    assert room.first_occupied.y == pytest.approx(11.5, abs=0.011)


def test_place_of_leaving_the_map_is_found() -> None:
    room = border_clearance(OccupancyMap(hall(), 0.05, ORIGIN), straight(1, 11, 3, 11))
    assert room.first_outside is not None
    assert room.first_outside.x == pytest.approx(2.0, abs=0.011)


def test_place_of_entering_unknown_space_is_found() -> None:
    cells = hall()
    cells[:, 60:] = UNKNOWN
    room = border_clearance(OccupancyMap(cells, 0.05, ORIGIN), straight(-1, 11, 1.9, 11))
    assert room.first_unknown is not None
    assert room.first_unknown.x == pytest.approx(1.0, abs=0.011)
    assert room.first_unknown.abscissa == pytest.approx(2.0, abs=0.011)


def test_map_without_walls_has_clearance_everywhere() -> None:
    occupancy = OccupancyMap(np.zeros((60, 80), np.uint8), 0.05, ORIGIN)
    assert border_clearance(occupancy, straight(-1, 11, 1, 11)).minimum > 6.9


def test_needed_clearance_follows_the_reach_of_the_corners() -> None:
    assert needed_clearance(0.3685) == NEEDED_CLEARANCE
    assert needed_clearance(0.4022) == 0.49


def test_each_stretch_that_is_too_near_is_listed_with_its_worst_place() -> None:
    cells = np.full((60, 200), FREE, dtype=np.uint8)
    cells[32:34, 50:60] = OCCUPIED  # 0.35 m beside the line, at x 2.5 to 3.0 m
    cells[28:30, 150:160] = OCCUPIED
    occupancy = OccupancyMap(cells, 0.05, Pose(0.0, -1.25, 0.0))
    line = Border([Segment((0.5, 0.0), (9.5, 0.0))], closed=False)
    first, second = border_clearance(occupancy, line).narrow_stretches(0.45)
    assert 1.5 < first.start < 2.0 < 2.5 < first.end < 3.0
    assert first.least == pytest.approx(0.35, abs=0.03)
    assert 7.0 < second.narrowest.x < 8.0
    assert str(second).startswith("s = ")
    assert border_clearance(occupancy, line).narrow_stretches(0.01) == []
