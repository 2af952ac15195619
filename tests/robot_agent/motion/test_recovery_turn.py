"""A robot that is lost stands, then turns left and right by turns."""

import math

from robot_agent.motion.recovery_turn import RecoveryTurn

WAIT, REST = 3.0, 8.0
TURNING = math.radians(400.0) / 0.4  # s


def test_stands_then_turns_to_both_sides_with_rests():
    turn = RecoveryTurn()
    first = WAIT + TURNING
    second = first + REST
    times = [0.0, WAIT - 0.1, WAIT, first - 0.1, first + 0.1, second - 0.1, second + 0.1]
    times += [second + TURNING - 0.1, second + TURNING + REST + 0.1]
    still, left, right = (0.0, 0.0), (0.0, 0.4), (0.0, -0.4)
    assert [turn.requested(100.0 + t) for t in times] == [
        *(still, still, left, left, still, still, right, right, left)
    ]


def test_found_again_it_begins_anew():
    turn = RecoveryTurn()
    assert not turn.end()
    turn.requested(0.0)
    assert turn.requested(4.0) != (0.0, 0.0)
    assert turn.end()
    assert not turn.end()
    assert turn.requested(5.0) == (0.0, 0.0)


def test_a_turn_shows_all_round():
    turn = RecoveryTurn()
    turn.requested(0.0)
    turned = sum(0.1 * turn.requested(WAIT + 0.1 * k)[1] for k in range(round(10 * TURNING)))
    assert turned > math.tau
