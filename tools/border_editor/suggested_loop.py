"""A loop along the middle of the free corridors, as a first border to change by hand.

The free space with enough room has holes: blocks of rooms, pillars, furniture. A cut from a hole
across the corridor beside it makes one end of a path on each of its sides; the cheapest path
between them, where room is cheap, goes once round the hole. The loop round the largest area is
simplified to the fewest vertices whose rounded border passes the check.
"""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np
from numpy.typing import NDArray

from maps.occupancy_map import OccupancyMap
from maps.shortest_paths import NOWHERE, shortest_paths
from tools.border_editor.border_draft import DEFAULT_RADIUS, BorderDraft, Vertex, fitting_radius
from tools.border_editor.draft_judgement import judge
from tools.border_editor.roomy_places import MARGIN, RoomyPlaces

_ENOUGH = 1.0  # m; wider than this a corridor's middle is no better than another place
_NARROW_COST = 4.0  # times the length of a way without any room
_CUT_ROWS = 2  # no step of a path leads over so many
_HOLES = 5  # largest ones tried
_SHARES = (0.5, 0.25, 0.75)  # of a hole's height and width, where cuts are tried
_LEAST_HOLE = 1.0  # m2
_LEAST_REGION = 10.0  # m2
_VERTEX_COSTS = 0.04  # m of clearance that are worth a vertex less
_SIMPLER = (0.6, 0.4, 0.3, 0.2, 0.15, 0.1, 0.07)  # m that the vertices' lines may be off the path


def suggest_loop(occupancy: OccupancyMap, needed: float) -> BorderDraft | None:
    """Return a closed draft that passes the check, the largest found; None if there is none.

    needed: clearance, m, that robots need.
    """
    for margin in (MARGIN, 0.0):
        roomy = RoomyPlaces(occupancy, needed, margin)
        for cells in sorted(_loops(roomy, occupancy.resolution), key=_area, reverse=True):
            draft = _draft_along(occupancy, occupancy.centres(cells), needed)
            if draft is not None:
                return draft
    return None


def _loops(roomy: RoomyPlaces, resolution: float) -> Iterator[NDArray[np.intp]]:
    """Yield loops round holes, each (n, 2) cells by row and column."""
    lack = 1.0 - np.minimum(roomy.room, _ENOUGH) / _ENOUGH
    for free in _regions(roomy.mask, _LEAST_REGION / resolution**2):
        cost = np.where(free, 1.0 + _NARROW_COST * lack, np.inf)
        for hole in _holes(free, _LEAST_HOLE / resolution**2):
            yield from _loops_round(cost, hole)


def _loops_round(cost: NDArray[np.float64], hole: NDArray[np.bool_]) -> Iterator[NDArray[np.intp]]:
    """Yield loops round a hole by cuts at several rows and columns."""
    rows, cols = np.nonzero(hole)
    for share in _SHARES:
        row = int(rows.min() + share * (rows.max() - rows.min()))
        col = int(cols.min() + share * (cols.max() - cols.min()))
        by_row, by_col = _loop_by_cut(cost, hole, row), _loop_by_cut(cost.T, hole.T, col)
        if by_row is not None:
            yield by_row
        if by_col is not None:
            yield by_col[:, ::-1]


def _regions(mask: NDArray[np.bool_], least: float) -> Iterator[NDArray[np.bool_]]:
    """Yield the masks of the connected regions of at least so many cells."""
    count, labels, figures, _ = cv2.connectedComponentsWithStats(
        mask.astype(np.uint8), connectivity=4
    )
    for number in range(1, count):
        if figures[number, cv2.CC_STAT_AREA] >= least:
            yield labels == number


def _holes(free: NDArray[np.bool_], least: float) -> Iterator[NDArray[np.bool_]]:
    """Yield the masks of the largest holes in a region, of at least so many cells."""
    count, labels, figures, _ = cv2.connectedComponentsWithStats(
        np.pad(~free, 1, constant_values=True).astype(np.uint8), connectivity=8
    )
    labels = labels[1:-1, 1:-1]
    outside = 1 + int(np.argmax(figures[1:, cv2.CC_STAT_WIDTH]))
    areas = [(int(figures[n, cv2.CC_STAT_AREA]), n) for n in range(1, count) if n != outside]
    for area, number in sorted(areas, reverse=True)[:_HOLES]:
        if area >= least:
            yield labels == number


def _loop_by_cut(
    cost: NDArray[np.float64], hole: NDArray[np.bool_], row: int
) -> NDArray[np.intp] | None:
    """Return the cheapest loop (n, 2) round a hole that crosses the cut right of it in a row."""
    row = min(max(row, 1), cost.shape[0] - _CUT_ROWS - 1)
    inside = np.flatnonzero(hole[row])
    if not len(inside):
        return None
    first = int(inside[-1]) + 1
    blocked = np.flatnonzero(~np.isfinite(cost[row, first:]))
    last = first + int(blocked[0]) if len(blocked) else cost.shape[1]
    if last <= first:
        return None
    col = first + int(np.argmin(cost[row, first:last]))
    cut = cost.copy()
    cut[row : row + _CUT_ROWS, first:last] = np.inf
    begin, end = (row - 1, col), (row + _CUT_ROWS, col)
    goals = np.zeros(cost.shape, dtype=np.bool_)
    goals[end] = True
    length, following = shortest_paths(cut, goals)
    if not np.isfinite(length[begin]):
        return None
    cell = begin[0] * cost.shape[1] + begin[1]
    path = [*((row + k, col) for k in reversed(range(_CUT_ROWS)))]
    while cell != NOWHERE:
        path.append(divmod(cell, cost.shape[1]))
        cell = int(following.flat[cell])
    return np.array(path)


def _area(loop: NDArray[np.intp]) -> float:
    y, x = loop.T.astype(float)
    return 0.5 * abs(float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))))


def _draft_along(
    occupancy: OccupancyMap, path: NDArray[np.float64], needed: float
) -> BorderDraft | None:
    """Return the best draft along a closed path (n, 2), m: few vertices and much clearance."""
    best, merit = None, -np.inf
    for off in _SIMPLER:
        corners = cv2.approxPolyDP(path.astype(np.float32)[:, None], off, closed=True)[:, 0]
        if len(corners) < 3:
            continue
        draft = _rounded([Vertex(round(float(x), 2), round(float(y), 2)) for x, y in corners])
        judgement = judge(occupancy, draft, needed)
        if judgement.ok and judgement.clearance is not None:
            worth = min(judgement.clearance, _ENOUGH) - _VERTEX_COSTS * len(corners)
            if worth > merit:
                best, merit = draft, worth
    return best


def _rounded(corners: list[Vertex]) -> BorderDraft:
    """Return a closed draft; corners too near each other for the default radius get their own."""
    vertices = []
    for number, corner in enumerate(corners):
        before, after = corners[number - 1], corners[(number + 1) % len(corners)]
        radius = round(fitting_radius(before, corner, after, DEFAULT_RADIUS) - 0.0005, 3)
        own = None if radius >= DEFAULT_RADIUS - 0.001 else max(radius, 0.001)
        vertices.append(Vertex(corner.x, corner.y, own))
    return BorderDraft(vertices=vertices)
