"""Distance of each cell's centre from the mapped surface, where the beams of a laser end.

In a drawn map walls are solid, and a beam ends on the face of the first occupied cell: the
distance is signed, negative inside a wall, and its interpolation between the cells' centres is 0
on the face. In a map built from scans an occupied cell is one in which beams ended, anywhere in
it: the distance is that from the middle of the cell.

Distances are cut at ``FAR``, so that a few rows of a map can be computed from those beside them.
Their squares are whole numbers of half cells, the same on every machine.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from maps.occupancy_map import FREE, OCCUPIED, Surface

FAR = 0.45
"""m; what lies farther from the surface than three of the refinement's kernels tells no more."""

_Squares = NDArray[np.uint16] | NDArray[np.uint32]


def reach_in_cells(resolution: float) -> int:
    """Return the number of cells beside one that its distance depends on; resolution: m."""
    return int(FAR / resolution + 0.5) + 1


def surface_distance(
    cells: NDArray[np.uint8], resolution: float, surface: Surface
) -> NDArray[np.float32]:
    """Return (rows, cols) distances, m, of cells' centres from the mapped surface, -FAR to FAR.

    Where the surface is the walls' faces, those to free cells: negative in the walls and beyond.
    FAR without a surface, or -FAR where nothing is free.
    """
    occupied, free = cells == OCCUPIED, cells == FREE
    if surface is Surface.CENTRE:
        return _roots(_squares(occupied, resolution, to_face=False), resolution)
    outside = _roots(_squares(occupied, resolution, to_face=True), resolution)
    # Of a wall to unknown ground only the face to the free side is seen.
    seen = free & _beside(occupied)
    inside = _roots(_squares(seen, resolution, to_face=True), resolution)
    return np.where(free, outside, -inside)


def _beside(cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return (rows, cols) which cells share a side with a chosen one."""
    padded = np.pad(cells, 1)
    return padded[:-2, 1:-1] | padded[2:, 1:-1] | padded[1:-1, :-2] | padded[1:-1, 2:]


def _squares(chosen: NDArray[np.bool_], resolution: float, *, to_face: bool) -> _Squares:
    """Return (rows, cols) squared distances, half cells, from the nearest chosen cell.

    to_face: from the point of that cell's square nearest to the centre of the other, not from its
    centre. More than FAR if none is within it. Both squares are sums of one term along the columns
    and one along the rows, so that each direction is searched alone.
    """
    reach = reach_in_cells(resolution)
    step = np.arange(1, reach + 1)
    along = (2 * step - 1 if to_face else 2 * step) ** 2
    dtype = np.uint16 if along[-1] < np.iinfo(np.uint16).max // 2 else np.uint32
    none = np.iinfo(dtype).max // 2
    squares = np.where(chosen, dtype(0), dtype(none))
    moved = np.empty_like(squares)
    for axis in range(2):
        nearest = squares.copy()
        for number, square in enumerate(along, start=1):
            np.add(squares, dtype(square), out=moved)
            ahead, behind = slice(number, None), slice(None, -number)
            for to, of in ((ahead, behind), (behind, ahead)):
                here = nearest[to] if axis == 0 else nearest[:, to]
                np.minimum(here, moved[of] if axis == 0 else moved[:, of], out=here)
        squares = nearest
    return squares


def _roots(squares: _Squares, resolution: float) -> NDArray[np.float32]:
    """Return the distances, m, up to FAR, of squared ones in half cells."""
    half = 0.5 * resolution
    last = int((FAR / half) ** 2) + 1
    distances = np.minimum(half * np.sqrt(np.arange(last + 1)), FAR).astype(np.float32)
    return np.asarray(distances.take(squares, mode="clip"))
