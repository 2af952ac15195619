"""Room round people nearby."""

import math

import numpy as np

from robot_agent.motion.footprint import Footprint
from robot_agent.motion.gate_limits import GateLimits
from robot_agent.motion.swept_footprint import SweptFootprint
from robot_agent.obstacles.person_room import RADIUS, PersonRoom

LIMITS = GateLimits()
ROOM = PersonRoom(Footprint(LIMITS), LIMITS.turn_margin)
BODY = SweptFootprint(LIMITS)


def turn_round(middle: tuple[float, float]) -> float:
    """Return the share of half a turn in place that is free beside a person."""
    return BODY.free_share(0.0, -math.pi, ROOM.around(np.array([middle])))


def test_rear_corner_does_not_sweep_through_the_feet_of_a_person_ahead() -> None:
    reach = math.hypot(LIMITS.rear + LIMITS.turn_margin, LIMITS.half_width + LIMITS.turn_margin)
    assert turn_round((reach + RADIUS - 0.03, 0.0)) < 1.0
    assert turn_round((reach + RADIUS + 0.01, 0.0)) == 1.0


def test_a_person_who_has_come_close_does_not_pin_the_robot() -> None:
    assert (
        BODY.free_share(0.0, 0.05, ROOM.around(np.array([[0.0, LIMITS.half_width + 0.2]]))) == 1.0
    )


def test_points_are_on_a_circle_round_each_person() -> None:
    people = np.array([[1.0, 0.5], [-1.5, 0.0]])
    points = ROOM.around(people)
    away = np.hypot(*(points[:, None] - people).transpose(2, 0, 1)).min(axis=1)
    assert np.allclose(away, RADIUS)
