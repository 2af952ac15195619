"""Keep-out circles round teammates."""

import math

import numpy as np
import pytest

from drivers.p2os.model import load_model
from robot_agent.motion.footprint import Footprint
from robot_agent.motion.gate_limits import GateLimits
from robot_agent.motion.gate_settings import GateSettings, gate_limits
from robot_agent.motion.swept_footprint import SweptFootprint
from robot_agent.obstacles.teammate_keep_out import TeammateKeepOut

KEEP_OUT = TeammateKeepOut(Footprint(GateLimits()))
PASSES = np.array([True])


def test_circle_of_a_larger_robot_is_larger() -> None:
    large = gate_limits(GateSettings(), load_model("powerbot"))
    assert KEEP_OUT.radius == 0.42
    assert TeammateKeepOut(Footprint(large)).radius == 0.73


def test_robot_stops_where_both_can_turn() -> None:
    """Also before a teammate that faces the robot, whose axle is nearer than its middle."""
    body, gate = SweptFootprint(GateLimits()), GateLimits()
    corner = math.hypot(gate.rear, gate.half_width)
    axle_before_middle = (gate.rear - gate.front) / 2.0
    for distance in np.arange(0.84, 1.6, 0.02):
        free = 1.0 * body.free_share(1.0, 0.0, KEEP_OUT.around(np.array([[distance, 0.0]])))
        assert distance - free - axle_before_middle > 2 * corner
    assert body.free_share(1.0, 0.0, KEEP_OUT.around(np.array([[2.2, 0.0]]))) == 1.0


@pytest.mark.parametrize("distance", [0.45, 0.6, 0.75])
def test_points_within_the_own_circle_are_left_out(distance: float) -> None:
    room = KEEP_OUT.around(np.array([[distance, 0.0], [0.0, -distance]]))
    assert SweptFootprint(GateLimits()).free_share(0.0, math.pi, room) == 1.0
    assert np.hypot(*room.T).min() > KEEP_OUT.radius


def test_turn_waits_until_a_robot_beside_has_passed() -> None:
    """Its rear comes to where the corner sweeps, out of sight; no point pins the robot for ever."""
    beside = np.array([[0.3, 0.65]])
    room = KEEP_OUT.around(beside, PASSES)
    assert SweptFootprint(GateLimits()).free_share(0.0, -1.2, room) < 1.0
    assert not Footprint(GateLimits()).covers(room).any()
    assert SweptFootprint(GateLimits()).free_share(0.0, -1.2, KEEP_OUT.around(beside)) == 1.0
