"""A room without symmetry, its map, and the scans a laser takes in it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from maps.occupancy_map import FREE, OCCUPIED, OccupancyMap, Surface
from maps.pose import Pose

RESOLUTION = 0.05
Ring = list[tuple[float, float]]

# Corners of the room (8 x 5 m with a niche) and of two boxes in it, m, in the map frame.
OUTLINE: Ring = [(0, 0), (8, 0), (8, 3.5), (6.5, 3.5), (6.5, 5), (0, 5)]
BOXES: list[Ring] = [
    [(1.5, 3.2), (2.6, 3.2), (2.6, 4.1), (1.5, 4.1)],
    [(5, 0), (5.4, 0), (5.4, 1.3), (5, 1.3)],
]


def _walls(rings: list[Ring]) -> NDArray[np.float64]:
    """(n, 4) segments x1, y1, x2, y2."""
    return np.array(
        [(*a, *b) for ring in rings for a, b in zip(ring, ring[1:] + ring[:1], strict=True)],
        dtype=np.float64,
    )


@dataclass(frozen=True)
class Room:
    """The true room; the map is drawn from it."""

    walls: NDArray[np.float64]
    map: OccupancyMap

    def scan(
        self,
        pose: Pose,
        rng: np.random.Generator | None = None,
        beams: int = 181,
        sigma: float = 0.01,
    ) -> NDArray[np.float64]:
        """End points (n, 2), base_link, of a laser at the base looking ahead over 180 degrees."""
        angles = np.linspace(-math.pi / 2, math.pi / 2, beams)
        ranges = self.ranges(pose, angles)
        if rng is not None:
            ranges = ranges + sigma * rng.standard_normal(beams)
        return np.column_stack((ranges * np.cos(angles), ranges * np.sin(angles)))

    def ranges(self, pose: Pose, angles: NDArray[np.float64]) -> NDArray[np.float64]:
        """Exact distances (n,) to the nearest wall at angles (n,) from the pose's heading."""
        ux, uy = np.cos(angles + pose.theta)[:, None], np.sin(angles + pose.theta)[:, None]
        x1, y1, x2, y2 = self.walls.T
        wx, wy = x2 - x1, y2 - y1
        with np.errstate(divide="ignore", invalid="ignore"):
            cross = ux * wy - uy * wx
            along = ((x1 - pose.x) * wy - (y1 - pose.y) * wx) / cross
            across = ((x1 - pose.x) * uy - (y1 - pose.y) * ux) / cross
        hit = (along > 0) & (across >= 0) & (across <= 1)
        return np.where(hit, along, np.inf).min(axis=1)


@pytest.fixture(scope="session")
def room() -> Room:
    """The room, mapped by the cells its walls run through."""
    return draw([OUTLINE, *BOXES], 8.0, 5.0)


@pytest.fixture(scope="session")
def twin_rooms() -> Room:
    """Two rooms without a door that are the same, the second 9 m beside the first."""
    return draw([ring for shift in (0.0, 9.0) for ring in shifted(shift)], 17.0, 5.0)


@pytest.fixture(scope="session")
def near_twin_rooms() -> Room:
    """Two rooms without a door; the second, 9 m beside the first, lacks one of two boxes."""
    return draw([*shifted(0.0), *shifted(9.0)[:-1]], 17.0, 5.0)


def shifted(x: float) -> list[Ring]:
    """The room's rings moved along x, m; a box on its right wall last."""
    return [[(a + x, b) for a, b in ring] for ring in (OUTLINE, *BOXES)]


def draw(rings: list[Ring], width: float, height: float) -> Room:
    """Build a room and its map; width and height in m."""
    walls = _walls(rings)
    margin = 0.5 + RESOLUTION / 2  # so that walls run through the middle of their cells
    rows, cols = round((height + 2 * margin) / RESOLUTION), round((width + 2 * margin) / RESOLUTION)
    cells = np.full((rows, cols), FREE, dtype=np.uint8)
    occupancy = OccupancyMap(cells, RESOLUTION, Pose(-margin, -margin, 0.0), Surface.CENTRE)
    for x1, y1, x2, y2 in walls:
        steps = np.linspace(0.0, 1.0, 500)[:, None]
        row, col = occupancy.cells_at(np.array([x1, y1]) + steps * np.array([x2 - x1, y2 - y1]))
        cells[row, col] = OCCUPIED
    return Room(walls, occupancy)


def drive(start: Pose, steps: int, v: float, w: float, dt: float = 0.1) -> list[Pose]:
    """Poses along a circle (or line), one per scan."""
    poses = [start]
    for _ in range(steps):
        turn = w * dt
        poses.append(
            poses[-1].compose(Pose(v * dt * math.cos(turn / 2), v * dt * math.sin(turn / 2), turn))
        )
    return poses


@pytest.fixture(scope="session")
def circle() -> list[Pose]:
    """Twenty seconds of patrol speed round the middle of the room, 10 scans a second."""
    return drive(Pose(4.0, 1.6, 0.2), 200, 0.35, 0.35)


@pytest.fixture(scope="session")
def corridor() -> Room:
    """A corridor of 24 x 2 m, bare but for its ends and one pillar's nose of 0.15 m."""
    nose: Ring = [(16.0, 0.0), (16.4, 0.0), (16.4, 0.15), (16.0, 0.15)]
    return draw([[(0, 0), (24, 0), (24, 2), (0, 2)], nose], 24.0, 2.0)
