"""Classification of gate decisions: held, pinned."""

import pytest

from robot_agent.motion.gate import GateDecision
from robot_agent.motion.gate_hold import STOPPING, held_by_obstacle, pinned_by_obstacle
from robot_agent.motion.gate_reason import GateReason


@pytest.mark.parametrize(
    ("decision", "held", "pinned"),
    [
        (None, False, False),
        (GateDecision(0.0, 0.0, GateReason.NONE), False, False),
        (GateDecision(0.0, 0.0, GateReason.STALE_LASER), False, False),
        (GateDecision(0.0, 0.0, GateReason.OBSTACLE), True, True),
        (GateDecision(0.0, -0.02, GateReason.OBSTACLE), True, True),
        (GateDecision(0.0, 0.3, GateReason.OBSTACLE), True, False),
        (GateDecision(0.0, -0.3, GateReason.OBSTACLE), True, False),
        (GateDecision(0.2, 0.0, GateReason.OBSTACLE), False, False),
    ],
)
def test_obstacles_hold_and_pin(decision, held: bool, pinned: bool) -> None:
    assert held_by_obstacle(decision) is held
    assert pinned_by_obstacle(decision) is pinned


def test_limits_do_not_stop() -> None:
    assert {GateReason.OBSTACLE, GateReason.STALE_LASER} <= STOPPING
    assert not STOPPING & {GateReason.NONE, GateReason.ACCELERATION, GateReason.MOTORS_OFF}
