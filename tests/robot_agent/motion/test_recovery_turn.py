"""A robot that is lost stands, then turns left and right by turns."""

import math

from robot_agent.motion.recovery_turn import RecoverySettings, RecoveryTurn

SETTINGS = RecoverySettings(wait=3.0, turn_rate=0.5, turn=5.0, rest=2.0)


def test_stands_then_turns_to_both_sides_with_rests():
    turn = RecoveryTurn(SETTINGS)
    seen = [
        (t, turn.requested(100.0 + t)) for t in (0.0, 2.9, 3.0, 12.9, 13.1, 14.9, 15.0, 24.9, 27.0)
    ]
    still, left, right = (0.0, 0.0), (0.0, 0.5), (0.0, -0.5)
    assert [requested for _, requested in seen] == [
        *(still, still, left, left, still, still, right, right, left)
    ]


def test_found_again_it_begins_anew():
    turn = RecoveryTurn(SETTINGS)
    assert not turn.end()
    turn.requested(0.0)
    assert turn.requested(4.0) != (0.0, 0.0)
    assert turn.end()
    assert not turn.end()
    assert turn.requested(5.0) == (0.0, 0.0)


def test_a_turn_shows_all_round():
    assert RecoverySettings().turn > math.tau
