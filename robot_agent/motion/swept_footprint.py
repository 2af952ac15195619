"""Collision check of the area that the footprint sweeps along an arc."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from robot_agent.motion.gate_limits import GateLimits
from robot_agent.motion.stopping import stopping_way
from robot_agent.motion.unpinning import EDGING_SPEED

POSES = 12  # per stopping way: at most 0.05 m apart at top speed, less than the margin
SHARES = np.arange(1, POSES + 1) / POSES
EDGING_SHARE = 1.135  # of EDGING_SPEED: a base rolls slightly faster than commanded
SEEN_INSIDE = 0.02  # m by which noise shifts points at side and rear into the footprint
LEAST_BACK = -SEEN_INSIDE  # m; margin of a turn back, of the points that are nearest
FREE_SHARES = np.arange(POSES) / POSES  # free up to the pose before the first collision
_Edge = float | NDArray[np.float64]
"""Distance of an edge of the footprint from the axle's middle, m: one, or one for each point."""


class SweptFootprint:
    """The footprint with its margins, moved along arcs among obstacles (n, 2), m, base_link."""

    def __init__(self, settings: GateLimits) -> None:
        self._settings = settings
        self._front = settings.front + settings.front_margin
        self._side = settings.half_width + settings.margin
        speed = EDGING_SHARE * EDGING_SPEED
        self._edging_way = stopping_way(speed, settings.braking, settings.reaction_delay)

    def free_share(
        self,
        way: float,
        turn: float,
        obstacles: NDArray[np.float64],
        more: float = 0.0,
        *,
        back: bool = False,
    ) -> float:
        """Return the share, 0 to 1, of an arc (way m, turn rad) free of obstacles (n, 2), m.

        more: m added to the margin of a turn in place; but points that are nearer already must
        come no nearer. back: whether the body has just been where a turn in place takes it; then
        that holds for points within the margin too.
        """
        if not len(obstacles):
            return 1.0
        settings = self._settings
        reach = way + settings.front + settings.rear + settings.half_width
        near = obstacles[np.maximum(*np.abs(obstacles.T)) < reach]
        if not len(near):
            return 1.0  # the usual case
        if way > 0.0:
            front, rear, side = self._driving(near)
            if turn == 0.0 and way <= self._edging_way:
                # Slow and straight ahead, out of a place too narrow to turn: the clearance to
                # points beside the robot does not shrink, that to points behind it grows.
                near = near[~self._beside_or_behind(near)]
        else:
            front, rear, side = self._turning(near, more, back=back)
        x, y = _seen_along_arc(way * SHARES, turn * SHARES, near)
        hit = ((x < front) & (x > -rear) & (np.abs(y) < side)).any(axis=1)
        return float(FREE_SHARES[hit.argmax()]) if hit.any() else 1.0

    def _driving(self, near: NDArray[np.float64]) -> tuple[_Edge, _Edge, _Edge]:
        """Return front, rear and side, m from the axle, with margins; near: points (n, 2), m."""
        settings = self._settings
        side = settings.half_width + self._side_margin(near)
        return self._front, settings.rear + settings.turn_margin, side

    def _turning(
        self, near: NDArray[np.float64], more: float, *, back: bool
    ) -> tuple[_Edge, _Edge, _Edge]:
        """Return the same for a turn in place, each (n,): of each of the points (n, 2), m."""
        settings = self._settings
        x, y = near.T
        clearance = np.maximum(
            np.maximum(x - settings.front, -settings.rear - x), np.abs(y) - settings.half_width
        )
        least = LEAST_BACK - settings.turn_margin if back else 0.0
        margin = settings.turn_margin + np.clip(clearance - settings.turn_margin, least, more)
        return settings.front + margin, settings.rear + margin, settings.half_width + margin

    def front_edge(self, way: float, turn: float) -> list[tuple[float, float]]:
        """Return the front edge's left end, middle and right end, margins included, after an arc.

        way, m, and turn, rad: of the arc. Positions (x, y), m, in base_link at its start.
        """
        front, side = self._front, self._side
        half = 0.5 * turn
        chord = way * (math.sin(half) / half if half else 1.0)
        x, y = chord * math.cos(half), chord * math.sin(half)
        c, s = math.cos(turn), math.sin(turn)
        return [
            (x + c * front - s * aside, y + s * front + c * aside) for aside in (side, 0.0, -side)
        ]

    def _beside_or_behind(self, near: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return (n,) which points (n, 2), m, base_link, are alongside or behind the footprint.

        Points slightly inside its edges, as noise shifts them, count as outside.
        """
        x, aside = near[:, 0], np.abs(near[:, 1])
        beside = (aside >= self._settings.half_width - SEEN_INSIDE) & (x < self._settings.front)
        behind = x <= SEEN_INSIDE - self._settings.rear
        return beside | behind

    def _side_margin(self, near: NDArray[np.float64]) -> float:
        """Return the margin, m, beside the body: reduced to the clearance of points alongside.

        With the full margin the robot could not drive away from a wall.
        """
        settings = self._settings
        x, aside = near[:, 0], np.abs(near[:, 1]) - settings.half_width
        alongside = (x < settings.front) & (x > -settings.rear)
        clearance = aside[alongside].min(initial=settings.margin)
        return max(float(clearance), settings.turn_margin)


def _seen_along_arc(
    ways: NDArray[np.float64], turns: NDArray[np.float64], points: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return (x, y), each (poses, n): points (n, 2) as seen from poses along one arc.

    ways (poses,) m and turns (poses,) rad from the start.
    """
    half = turns / 2.0
    chord = ways * np.sinc(half / np.pi)  # sinc: sin(half) / half, 1 when straight
    c, s = np.cos(turns)[:, None], np.sin(turns)[:, None]
    px, py = np.ascontiguousarray(points.T)
    # The chord is at half the turn from the start, and at minus half seen from the end pose.
    x = c * px + s * py - (chord * np.cos(half))[:, None]
    y = c * py - s * px + (chord * np.sin(half))[:, None]
    return x, y
