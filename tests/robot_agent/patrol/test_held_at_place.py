"""Time at one place: counted within a radius, restarted by moving, a pause or on request."""

from robot_agent.patrol.held_at_place import HeldAtPlace


def test_time_counts_from_the_first_update_within_the_radius():
    held = HeldAtPlace(0.3)
    assert held.update(5.0, (1.0, 1.0)) == 0.0
    assert held.update(7.0, (1.2, 1.0)) == 2.0


def test_moving_beyond_the_radius_of_the_first_place_restarts_the_count():
    held = HeldAtPlace(0.25)
    for k in range(5):
        held.update(float(k), (0.1 * k, 0.0))
    assert held.update(5.0, (0.5, 0.0)) == 2.0  # anew at 0.3 m


def test_a_pause_restarts_the_count_only_if_one_is_set():
    paused, patient = HeldAtPlace(0.3, 1.0), HeldAtPlace(0.3)
    for held in (paused, patient):
        held.update(0.0, (0.0, 0.0))
    assert paused.update(1.5, (0.0, 0.0)) == 0.0
    assert patient.update(1.5, (0.0, 0.0)) == 1.5


def test_restart_may_lie_ahead_and_forget_starts_at_the_next_update():
    held = HeldAtPlace(0.3)
    held.restart(8.0, (0.0, 0.0))
    assert held.update(6.0, (0.0, 0.0)) == -2.0
    held.forget()
    assert held.update(9.0, (0.0, 0.0)) == 0.0
