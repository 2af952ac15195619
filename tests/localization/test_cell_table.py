"""The table of a map's cells: states and distances, cropped to what is known."""

from __future__ import annotations

import numpy as np
import pytest

from localization.cell_table import (
    DISTANCE_BITS,
    DISTANCE_MASK,
    DISTANCE_STEP,
    ON_SURFACE,
    cell_table,
)
from localization.surface_distance import surface_distance
from maps.occupancy_map import UNKNOWN, OccupancyMap, Surface
from maps.pose import Pose

CELL = 0.1


def drawn(surface: Surface, rows: int = 700) -> OccupancyMap:
    """Random cells of all states over more rows than are computed at once."""
    rng = np.random.default_rng(2)
    cells = rng.choice(3, (rows, 40), p=(0.9, 0.04, 0.06)).astype(np.uint8)
    return OccupancyMap(cells, CELL, Pose(2.0, -3.0, 0.0), surface)


@pytest.mark.parametrize("surface", list(Surface))
def test_states_and_distances_are_those_of_the_whole_map(surface: Surface) -> None:
    occupancy = drawn(surface)
    codes = cell_table(occupancy).codes[1:-1, 1:-1]
    np.testing.assert_array_equal(codes >> DISTANCE_BITS, occupancy.cells)
    distance = ((codes & DISTANCE_MASK) - float(ON_SURFACE)) * DISTANCE_STEP
    expected = surface_distance(occupancy.cells, CELL, surface)
    np.testing.assert_allclose(distance, expected, atol=DISTANCE_STEP)


@pytest.mark.parametrize("surface", list(Surface))
def test_unknown_surroundings_are_left_out(surface: Surface) -> None:
    inner = drawn(surface, 60)
    cells = np.pad(inner.cells, 500, constant_values=UNKNOWN)
    off = 500 * CELL
    wide = OccupancyMap(cells, CELL, Pose(2.0 - off, -3.0 - off, 0.0), surface)
    table = cell_table(wide)
    assert table.codes.size < 2 * inner.cells.size
    row, col = (
        round((start - low) / CELL)
        for start, low in ((-3.0, table.corner.imag), (2.0, table.corner.real))
    )
    rows, cols = inner.cells.shape
    np.testing.assert_array_equal(
        table.codes[row : row + rows, col : col + cols] >> DISTANCE_BITS, inner.cells
    )


def test_rim_is_unknown_and_on_the_same_side_of_the_surface() -> None:
    codes = cell_table(drawn(Surface.FACE)).codes
    for rim, edge in ((codes[0], codes[1]), (codes[:, -1], codes[:, -2])):
        assert (rim >> DISTANCE_BITS == UNKNOWN).all()
        outside = (edge & DISTANCE_MASK) >= ON_SURFACE
        inner = slice(1, -1)
        assert ((rim[inner] & DISTANCE_MASK) == 2 * ON_SURFACE * outside[inner]).all()


def test_a_map_of_which_nothing_is_known_has_a_table() -> None:
    nothing = OccupancyMap(np.full((50, 60), UNKNOWN, np.uint8), CELL, Pose(0, 0, 0))
    assert (cell_table(nothing).codes >> DISTANCE_BITS == UNKNOWN).all()


def test_a_map_has_one_table() -> None:
    occupancy = drawn(Surface.CENTRE, 10)
    assert cell_table(occupancy) is cell_table(occupancy)
