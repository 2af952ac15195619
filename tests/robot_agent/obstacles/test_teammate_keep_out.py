"""Keep-out circles round teammates."""

import math

import numpy as np
import pytest

from drivers.p2os.model import load_model
from robot_agent.motion.footprint import Footprint
from robot_agent.motion.gate_limits import GateLimits
from robot_agent.motion.gate_settings import GateSettings, gate_limits
from robot_agent.motion.stopping import stopping_way
from robot_agent.motion.swept_footprint import SweptFootprint
from robot_agent.obstacles.teammate_keep_out import TeammateKeepOut

KEEP_OUT = TeammateKeepOut(Footprint(GateLimits()))
PASSES = np.array([True])


LONG = gate_limits(GateSettings(), load_model("powerbot"))


def test_circle_of_a_larger_robot_is_larger() -> None:
    assert KEEP_OUT.radius == 0.42
    assert TeammateKeepOut(Footprint(LONG)).radius == 0.73


def test_robot_stops_where_both_can_turn() -> None:
    """Also before a teammate that faces the robot, whose axle is nearer than its middle."""
    body, gate = SweptFootprint(GateLimits()), GateLimits()
    corner = math.hypot(gate.rear, gate.half_width)
    axle_before_middle = (gate.rear - gate.front) / 2.0
    for distance in np.arange(0.84, 1.6, 0.02):
        free = 1.0 * body.free_share(1.0, 0.0, KEEP_OUT.around(np.array([[distance, 0.0]])))
        assert distance - free - axle_before_middle > 2 * corner
    assert body.free_share(1.0, 0.0, KEEP_OUT.around(np.array([[2.2, 0.0]]))) == 1.0


@pytest.mark.parametrize("limits", [GateLimits(), LONG], ids=["short", "long"])
def test_room_near_ahead_stops_driving_but_no_turn(limits: GateLimits) -> None:
    """Also where a teammate was taken for something else for a while, and is near already."""
    keep_out, body = TeammateKeepOut(Footprint(limits)), SweptFootprint(limits)
    braking = stopping_way(limits.max_turn_rate, limits.turn_braking, limits.reaction_delay)
    touching = keep_out.radius + limits.front
    for distance in np.arange(touching + 0.05, touching + limits.front_margin, 0.01):
        room = keep_out.around(np.array([[distance, 0.0]]))
        assert body.free_share(0.05, 0.0, room) == 0.0, distance
        assert body.free_share(0.0, braking, room) == body.free_share(0.0, -braking, room) == 1.0


@pytest.mark.parametrize("distance", [0.45, 0.6, 0.75])
def test_points_within_the_own_circle_are_left_out(distance: float) -> None:
    room = KEEP_OUT.around(np.array([[distance, 0.0], [0.0, -distance]]))
    braking = stopping_way(1.5, GateLimits().turn_braking, GateLimits().reaction_delay)
    assert SweptFootprint(GateLimits()).free_share(0.0, braking, room) == 1.0
    ahead = room[:, 0] > GateLimits().front
    assert np.hypot(*room[~ahead].T).min() > KEEP_OUT.radius
    assert np.hypot(*room[ahead].T).min() > KEEP_OUT.own_ahead


def test_turn_waits_until_a_robot_beside_has_passed() -> None:
    """Its rear comes to where the corner sweeps, out of sight; no point pins the robot for ever."""
    beside = np.array([[0.3, 0.65]])
    room = KEEP_OUT.around(beside, PASSES)
    assert SweptFootprint(GateLimits()).free_share(0.0, -1.2, room) < 1.0
    assert not Footprint(GateLimits()).covers(room).any()
    assert SweptFootprint(GateLimits()).free_share(0.0, -1.2, KEEP_OUT.around(beside)) == 1.0
