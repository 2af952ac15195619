"""The recovery behavior: wait, then turn left and right alternately."""

import math

from robot_agent.motion.recovery_turn import RecoveryTurn

WAIT, REST = 3.0, 8.0
TURNING = math.radians(400.0) / 0.4  # s


def test_lost_robot_waits_then_turns_alternately():
    turn = RecoveryTurn()
    first = WAIT + TURNING
    second = first + REST
    times = [0.0, WAIT - 0.1, WAIT, first - 0.1, first + 0.1, second - 0.1, second + 0.1]
    times += [second + TURNING - 0.1, second + TURNING + REST + 0.1]
    still, left, right = (0.0, 0.0), (0.0, 0.4), (0.0, -0.4)
    assert [turn.requested(100.0 + t) for t in times] == [
        *(still, still, left, left, still, still, right, right, left)
    ]


def test_recovery_starts_again_after_the_pose_was_known():
    turn = RecoveryTurn()
    assert not turn.end()
    turn.requested(0.0)
    assert turn.requested(4.0) != (0.0, 0.0)
    assert turn.end()
    assert not turn.end()
    assert turn.requested(5.0) == (0.0, 0.0)


def test_one_turn_covers_a_full_circle():
    turn = RecoveryTurn()
    turn.requested(0.0)
    turned = sum(0.1 * turn.requested(WAIT + 0.1 * k)[1] for k in range(round(10 * TURNING)))
    assert turned > math.tau
