"""Overload: three late steps in a row begin it, ten in time end it."""

from robot_agent.motion.deadline_watch import DeadlineWatch

LATE, IN_TIME = 0.11, 0.1


def watch_of(*lags: float) -> DeadlineWatch:
    watch = DeadlineWatch()
    for lag in lags:
        watch.note(lag)
    return watch


def test_three_late_steps_in_a_row_are_an_overload():
    assert not watch_of(LATE, LATE).overloaded
    assert watch_of(LATE, LATE, LATE).overloaded


def test_a_step_in_time_breaks_the_row():
    watch = watch_of(LATE, LATE, IN_TIME, LATE, LATE)
    assert not watch.overloaded
    assert watch.missed == 4


def test_ten_steps_in_time_end_it():
    assert watch_of(*[LATE] * 3, *[IN_TIME] * 9).overloaded
    assert watch_of(*[LATE] * 3, *[IN_TIME] * 9, LATE, *[IN_TIME] * 9).overloaded
    assert not watch_of(*[LATE] * 3, *[IN_TIME] * 10).overloaded
