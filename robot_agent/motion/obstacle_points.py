"""Obstacle points for the gate, with the source of each."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray


class ObstacleSource(StrEnum):
    """Source of an obstacle point."""

    LASER = "laser"  # in the latest scan
    REMEMBERED = "remembered"  # in an earlier scan, out of the laser's view since
    SONAR = "sonar"
    MAP_WALL = "map_wall"  # out of the laser's view
    TEAMMATE_ROOM = "teammate_room"  # keep-out circle of a teammate nearby
    PERSON_ROOM = "person_room"  # round a person nearby, whose legs the laser sees


class ObstaclePoints(NamedTuple):
    """Points (n, 2), m, base_link, grouped by source; parts: (source, number of points) of each."""

    points: NDArray[np.float64]
    parts: tuple[tuple[ObstacleSource, int], ...] = ()

    @classmethod
    def joined(cls, parts: Sequence[tuple[ObstacleSource, NDArray[np.float64]]]) -> Self:
        """Return the points of all sources, in their order."""
        points = np.concatenate([points for _source, points in parts])
        return cls(points, tuple((source, len(points)) for source, points in parts))

    def source_of(self, index: int) -> ObstacleSource:
        """Return the source of the point with an index. Raises IndexError beyond the last point."""
        for source, count in self.parts:
            if index < count:
                return source
            index -= count
        raise IndexError("no such obstacle")


NO_OBSTACLES = ObstaclePoints(np.empty((0, 2)))
