"""A rectangular room seen by a small ray caster of its own, for the perception tests."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from maps.occupancy_map import FREE, OCCUPIED, UNKNOWN, OccupancyMap
from maps.pose import Pose
from robot_agent.perception.silhouette import NAMED, Silhouettes, rectangle

BODY = rectangle(0.511, 0.425)
"""A 2-DX with its bumpers, m."""
SILHOUETTES = Silhouettes.admitted(NAMED, BODY)
WIDTH, HEIGHT = 12.0, 8.0  # m, walls' inner faces at x = 0, WIDTH and y = 0, HEIGHT
RESOLUTION = 0.05
RIM = 1.0  # m of map around the room
INCREMENT = math.radians(1.0)


class Box(NamedTuple):
    """An upright object: centre m, heading rad, length and width m."""

    x: float
    y: float
    theta: float
    length: float = 0.511
    width: float = 0.425


class Room:
    """Free inside, one cell of wall, unknown beyond."""

    def __init__(self) -> None:
        rim = round(RIM / RESOLUTION)
        cells = np.full(
            (round(HEIGHT / RESOLUTION) + 2 * rim, round(WIDTH / RESOLUTION) + 2 * rim),
            UNKNOWN,
            dtype=np.uint8,
        )
        cells[rim - 1 : 1 - rim, rim - 1 : 1 - rim] = OCCUPIED
        cells[rim:-rim, rim:-rim] = FREE
        self.map = OccupancyMap(cells=cells, resolution=RESOLUTION, origin=Pose(-RIM, -RIM, 0.0))

    def scan(
        self,
        pose: Pose,
        boxes: Sequence[Box],
        rng: np.random.Generator,
        increment: float = INCREMENT,
    ) -> NDArray[np.float64]:
        """Return the points (n, 2), base_link, of a front half turn at the true pose."""
        bearings = np.arange(-math.pi / 2, math.pi / 2 + increment / 2, increment)
        ranges = _to_walls(pose, bearings)
        for box in boxes:
            ranges = np.minimum(ranges, _to_box(pose, bearings, box))
        ranges += rng.normal(0.0, 0.01, ranges.shape)
        return ranges[:, None] * np.column_stack((np.cos(bearings), np.sin(bearings)))


def _to_walls(pose: Pose, bearings: NDArray[np.float64]) -> NDArray[np.float64]:
    c, s = np.cos(pose.theta + bearings), np.sin(pose.theta + bearings)
    with np.errstate(divide="ignore"):
        to_x = np.where(c > 0, WIDTH - pose.x, pose.x) / np.abs(c)
        to_y = np.where(s > 0, HEIGHT - pose.y, pose.y) / np.abs(s)
    return np.minimum(to_x, to_y)


def _to_box(pose: Pose, bearings: NDArray[np.float64], box: Box) -> NDArray[np.float64]:
    seen_from = Pose(box.x, box.y, box.theta).between(pose)
    c, s = np.cos(seen_from.theta + bearings), np.sin(seen_from.theta + bearings)
    with np.errstate(divide="ignore"):
        x1, x2 = (-box.length / 2 - seen_from.x) / c, (box.length / 2 - seen_from.x) / c
        y1, y2 = (-box.width / 2 - seen_from.y) / s, (box.width / 2 - seen_from.y) / s
    enter = np.maximum(np.minimum(x1, x2), np.minimum(y1, y2))
    leave = np.minimum(np.maximum(x1, x2), np.maximum(y1, y2))
    return np.where((leave >= enter) & (enter > 0), enter, np.inf)


def shaken(pose: Pose, rng: np.random.Generator) -> Pose:
    """Return a pose with the errors of a localizer: 0.05 m and 1 degree, one sigma."""
    dx, dy = rng.normal(0.0, 0.05, 2)
    return Pose(pose.x + dx, pose.y + dy, pose.theta + rng.normal(0.0, math.radians(1.0)))
