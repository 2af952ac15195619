"""The paper's elementary behaviors: each turns a position into a task velocity and its Jacobian.

All positions, tangents and velocities are in the map frame, m and m/s.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import msgspec

from maps.border import BorderProjection

if TYPE_CHECKING:  # importing it takes SciPy
    from maps.approach_field import Approach

CLOCKWISE = 1  # growing abscissa
COUNTER_CLOCKWISE = -1

COINCIDENT = 1e-3  # m; the direction between points nearer than this is undefined

Vector = tuple[float, float]


class Task(msgspec.Struct, frozen=True):
    """Task of one behavior.

    velocity: n components, m/s in the map frame; jacobian: m rows of n, the directions in which
    the task fixes the velocity.
    """

    velocity: Sequence[float]
    jacobian: Sequence[Sequence[float]]


def reach_around_walls(approach: Approach, *, gain: float, speed_limit: float) -> Task:
    """Follow the shortest path round walls to the border: eq. 6 along that path.

    The distance of eq. 6 is the path's length and r_rf its first direction, which is the Jacobian.
    """
    dx, dy = approach.direction
    speed = min(gain * approach.distance, speed_limit)
    return Task((speed * dx, speed * dy), ((dx, dy),))


def reach_frontier(
    position: Vector, foot: BorderProjection, *, gain: float, speed_limit: float, beyond_end: bool
) -> Task:
    """Drive straight to the border (eq. 6), at gain * distance up to speed_limit.

    foot: projection of the position on the border. On the border itself r_rf is the border's
    normal. beyond_end: the robot is past the end of an open border; the Jacobian is the normal
    then, so that tasks of lower priority may move it back along the tangent.
    """
    away = (position[0] - foot.x, position[1] - foot.y)
    distance = math.hypot(*away)
    if distance < COINCIDENT:
        away, distance = foot.normal, 0.0
    else:
        away = (away[0] / distance, away[1] / distance)
    speed = min(gain * distance, speed_limit)
    claimed = foot.normal if beyond_end else away
    return Task((-speed * away[0], -speed * away[1]), (claimed,))


def patrol_clockwise(foot: BorderProjection, *, speed: float) -> Task:
    """Follow the border clockwise, towards increasing abscissa (eq. 7), at speed m/s."""
    return patrol_onward(foot, CLOCKWISE, speed=speed)


def patrol_counter_clockwise(foot: BorderProjection, *, speed: float) -> Task:
    """Follow the border counter-clockwise, towards decreasing abscissa, at speed m/s."""
    return patrol_onward(foot, COUNTER_CLOCKWISE, speed=speed)


def patrol_onward(foot: BorderProjection, direction: int, *, speed: float) -> Task:
    """Follow the border in the current direction, +1 clockwise or -1 (v_p of eq. 11)."""
    tx, ty = foot.tangent
    along = direction * speed
    return Task((along * tx, along * ty), ((tx, ty),))


def teammate_avoidance(
    position: Vector,
    teammate: Vector,
    *,
    gain: float,
    safety_distance: float,
    speed_limit: float,
    fallback: Vector,
) -> Task:
    """Move away from a teammate nearer than safety_distance (eq. 8), up to speed_limit.

    Beyond that distance the velocity is zero, where eq. 8 would attract. fallback: unit vector to
    leave along when both positions coincide.
    """
    away = (position[0] - teammate[0], position[1] - teammate[1])
    distance = math.hypot(*away)
    away = fallback if distance < COINCIDENT else (away[0] / distance, away[1] / distance)
    speed = min(max(gain * (safety_distance - distance), 0.0), speed_limit)
    return Task((speed * away[0], speed * away[1]), (away,))
