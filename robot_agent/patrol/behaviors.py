"""The paper's elementary behaviors: each turns a position into a task velocity and its Jacobian.

All positions, tangents and velocities are in the map frame, m and m/s.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import msgspec

from maps.border import BorderProjection

if TYPE_CHECKING:  # it brings scipy along
    from maps.approach_field import Approach

CLOCKWISE = 1  # growing abscissa
COUNTER_CLOCKWISE = -1

_ON_THE_SPOT = 1e-3  # m; nearer than this a direction between two points means nothing

Vector = tuple[float, float]


class Task(msgspec.Struct, frozen=True):
    """What one behavior asks for.

    velocity: n components; jacobian: m rows of n, the directions it claims.
    """

    velocity: Sequence[float]
    jacobian: Sequence[Sequence[float]]


def reach_around_walls(approach: Approach, *, gain: float, speed_limit: float) -> Task:
    """Follow the way to a border that a wall hides: eq. 6 along the way instead of the straight.

    Its distance is that along the way and r_rf the way's direction, which the Jacobian claims.
    """
    dx, dy = approach.direction
    speed = min(gain * approach.distance, speed_limit)
    return Task((speed * dx, speed * dy), ((dx, dy),))


def reach_frontier(
    position: Vector, foot: BorderProjection, *, gain: float, speed_limit: float, beyond_end: bool
) -> Task:
    """Go straight to the border (eq. 6), at gain * distance up to speed_limit.

    foot: projection of the position. On the border itself r_rf is the border's normal; so is the
    Jacobian of a robot beyond_end of an open border, which leaves the way back along it free.
    """
    away = (position[0] - foot.x, position[1] - foot.y)
    distance = math.hypot(*away)
    if distance < _ON_THE_SPOT:
        away, distance = foot.normal, 0.0
    else:
        away = (away[0] / distance, away[1] / distance)
    speed = min(gain * distance, speed_limit)
    claimed = foot.normal if beyond_end else away
    return Task((-speed * away[0], -speed * away[1]), (claimed,))


def patrol_clockwise(foot: BorderProjection, *, speed: float) -> Task:
    """Follow the border clockwise, that is towards growing abscissa (eq. 7)."""
    return patrol_onward(foot, CLOCKWISE, speed=speed)


def patrol_counter_clockwise(foot: BorderProjection, *, speed: float) -> Task:
    """Follow the border counter-clockwise, towards falling abscissa."""
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

    Beyond that distance it asks for nothing; eq. 8 would pull the robot back. fallback: unit
    vector to leave along when both stand on one spot.
    """
    away = (position[0] - teammate[0], position[1] - teammate[1])
    distance = math.hypot(*away)
    away = fallback if distance < _ON_THE_SPOT else (away[0] / distance, away[1] / distance)
    speed = min(max(gain * (safety_distance - distance), 0.0), speed_limit)
    return Task((speed * away[0], speed * away[1]), (away,))
