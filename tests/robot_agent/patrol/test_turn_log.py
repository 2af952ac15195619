"""The log of turns: latest first, by cause and direction, bounded."""

from robot_agent.patrol.turn_log import Turn, TurnCause, TurnLog


def test_latest_is_none_before_the_first_turn():
    log = TurnLog()
    assert log.latest is None
    log.add(Turn(1.0, 2.0, 1, TurnCause.CHANCE))
    assert log.latest == Turn(1.0, 2.0, 1, TurnCause.CHANCE)


def test_latest_first_yields_one_cause_and_direction_in_reverse_order():
    log = TurnLog()
    for t, direction, cause in (
        (1.0, 1, TurnCause.TEAMMATE),
        (2.0, -1, TurnCause.TEAMMATE),
        (3.0, 1, TurnCause.CHANCE),
        (4.0, 1, TurnCause.TEAMMATE),
    ):
        log.add(Turn(t, 0.0, direction, cause))
    assert [turn.t for turn in log.latest_first(TurnCause.TEAMMATE, 1)] == [4.0, 1.0]


def test_old_turns_are_dropped():
    log = TurnLog()
    for k in range(1000):
        log.add(Turn(float(k), 0.0, 1, TurnCause.CHANCE))
    kept = list(log.latest_first(TurnCause.CHANCE, 1))
    assert len(kept) < 1000
    assert kept[0].t == 999.0
