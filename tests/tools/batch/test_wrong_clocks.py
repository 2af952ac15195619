"""Wrong clocks of a team: drawn by the seed, within what is asked for."""

from robot_agent.patrol.common_clock import CommonClock
from tools.batch.wrong_clocks import wrong_clocks


def test_clocks_are_wrong_by_no_more_than_asked_for_and_differ():
    clocks = wrong_clocks(50, seed=1, error=3.0, gain=86.4)
    assert len({clock.start for clock in clocks}) == 50
    assert 2.0 < max(abs(clock.start) for clock in clocks) <= 3.0
    assert all(abs(clock.at(1000.0) - clock.at(0.0) - 1000.0) <= 1.0 for clock in clocks)


def test_right_clocks_and_the_same_seed():
    assert wrong_clocks(3, seed=2, error=0.0, gain=0.0) == [CommonClock(0.0)] * 3
    assert wrong_clocks(3, 2, 1.0, 1.0) == wrong_clocks(3, 2, 1.0, 1.0)


def test_a_known_drift_leaves_the_right_time():
    known = wrong_clocks(3, 1, error=0.0, gain=5000.0, drift_known=True)
    unknown = wrong_clocks(3, 1, error=0.0, gain=5000.0)
    assert max(abs(clock.at(2400.0) - 2400.0) for clock in known) < 9.0  # (gain / day)^2
    assert max(abs(clock.at(2400.0) - 2400.0) for clock in unknown) > 50.0
