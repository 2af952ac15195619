"""Start poses for simulated teams: off the border, with a free path to it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from maps.border import Border
from maps.occupancy_map import FREE, OccupancyMap
from maps.pose import Pose

_CLEAR = 0.5  # m from every wall
_ROOM = 0.05  # m, of larger robots
_WAY_CLEAR = 0.4  # m from every wall on the straight path to the border
FROM_BORDER = (1.0, 3.0)
"""Distances from the border, m, between which robots start by default."""
_APART = (3.0, 2.5, 2.0, 1.6, 1.3)  # m between any two, tried in this order
_CANDIDATES = 3000  # cells looked at
_ORDERS = 30  # random orders tried before the next smaller distance


class StartPoseError(ValueError):
    """A map has no room for so many robots; the message names how many fit."""


def free_start_poses(
    occupancy: OccupancyMap,
    border: Border,
    count: int,
    rng: np.random.Generator,
    reach: float = 0.0,
    from_border: tuple[float, float] = FROM_BORDER,
) -> list[Pose]:
    """Return ``count`` poses (map_from_base) with random headings.

    reach: m from base_link to a robot's farthest corner. from_border: least and greatest distance,
    m. Each is at least 0.5 m clear of walls, farther if the robot reaches farther, with a straight
    way to the border's closest point that stays 0.4 m clear, and more than 3 m from the others, or
    as far as there is room for so many, but more than 1.3 m, or than two robots reach.

    Raises StartPoseError if the map has no room for them.
    """
    # Cells that are not known to be free have no clearance.
    clearance = np.where(
        occupancy.cells == FREE, occupancy.distance_field() - occupancy.resolution / 2, 0.0
    )
    clear = max(_CLEAR, reach + _ROOM)
    points = _points_at(from_border, occupancy, clearance, clear, border, rng)
    fitting = 0
    for apart in [apart for apart in _APART if apart > 2 * reach]:
        for _ in range(_ORDERS):
            order = points[rng.permutation(len(points))]
            chosen = _far_apart(order, apart, count, occupancy, clearance, border)
            if len(chosen) == count:
                return [_with_random_heading(place, rng) for place in chosen]
            fitting = max(fitting, len(chosen))
    raise StartPoseError(
        f"no room for {count} robots, found places for {fitting} ({clear:.2f} m clear, "
        f"{from_border[0]:g} to {from_border[1]:g} m from the border, {_APART[-1]:g} m apart): "
        "use fewer robots or a larger map"
    )


def _far_apart(
    points: NDArray[np.float64],
    apart: float,
    count: int,
    occupancy: OccupancyMap,
    clearance: NDArray[np.float64],
    border: Border,
) -> list[NDArray[np.float64]]:
    """Return up to ``count`` points that are ``apart`` m from each other and have a free path."""
    chosen: list[NDArray[np.float64]] = []
    left = points
    while len(left) and len(chosen) < count:
        point, left = left[0], left[1:]
        if _way_is_free(occupancy, clearance, border, point):
            chosen.append(point)
            left = left[np.hypot(*(left - point).T) > apart]
    return chosen


def _with_random_heading(place: NDArray[np.float64], rng: np.random.Generator) -> Pose:
    """Return a pose at a place with a random heading."""
    return Pose(float(place[0]), float(place[1]), rng.uniform(-math.pi, math.pi))


def _points_at(
    from_border: tuple[float, float],
    occupancy: OccupancyMap,
    clearance: NDArray[np.float64],
    clear: float,
    border: Border,
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    """Return centres (n, 2), map frame, of clear cells at the right distance from the border."""
    points = occupancy.centres(np.argwhere(clearance >= clear))
    _, distances = border.project_many(points)
    near = points[(distances >= from_border[0]) & (distances <= from_border[1])]
    return np.asarray(near[rng.permutation(len(near))[:_CANDIDATES]])


def _way_is_free(
    occupancy: OccupancyMap,
    clearance: NDArray[np.float64],
    border: Border,
    point: NDArray[np.float64],
) -> bool:
    """Return whether the straight path from a point to the border stays clear of walls."""
    foot = border.project(float(point[0]), float(point[1]))
    steps = math.ceil(foot.distance / occupancy.resolution) + 1
    way = np.linspace(point, (foot.x, foot.y), steps)
    rows, cols = occupancy.cells_at(way)
    if not occupancy.inside(rows, cols).all():
        return False
    return bool(clearance[rows, cols].min() >= _WAY_CLEAR)
