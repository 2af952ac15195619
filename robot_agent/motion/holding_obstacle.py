"""Which obstacle holds the robot: for telemetry only, without effect on the gate."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robot_agent.motion.gate_limits import GateLimits
from robot_agent.motion.obstacle_points import ObstaclePoints, ObstacleSource
from robot_agent.motion.stopping import stopping_way
from robot_agent.motion.swept_footprint import SweptFootprint


class HoldingObstacle(NamedTuple):
    """An obstacle in the way: its source and position (x, y), m, base_link."""

    source: ObstacleSource
    x: float
    y: float


def holding_obstacle(
    settings: GateLimits, requested: tuple[float, float], obstacles: ObstaclePoints
) -> HoldingObstacle | None:
    """Return the first obstacle the robot would reach while stopping from a requested (v, w).

    v in m/s, w in rad/s. None if the arc, and else the turn in place, are free.
    """
    v, w = requested
    body, delay = SweptFootprint(settings), settings.reaction_delay
    turn = math.copysign(stopping_way(abs(w), settings.turn_braking, delay), w)
    sweeps = [(0.0, turn)]
    if v > settings.creep_speed:
        stop = stopping_way(v, settings.braking, delay)
        sweeps.insert(0, (stop, stop * w / v))
    for way, angle in sweeps:
        index = _first_in_way(body, way, angle, obstacles.points)
        if index is not None:
            x, y = obstacles.points[index].tolist()
            return HoldingObstacle(obstacles.source_of(index), x, y)
    return None


def _first_in_way(
    body: SweptFootprint, way: float, turn: float, points: NDArray[np.float64]
) -> int | None:
    """Return the index of the point (n, 2) that ends the free share of an arc, by halving."""
    share = body.free_share(way, turn, points)
    if share == 1.0:
        return None
    candidates = np.arange(len(points))
    while len(candidates) > 1:
        half = candidates[: len(candidates) // 2]
        hit = body.free_share(way, turn, points[half]) <= share
        candidates = half if hit else candidates[len(half) :]
    return int(candidates[0])
