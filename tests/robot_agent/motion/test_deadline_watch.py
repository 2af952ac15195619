"""Overload: three missed deadlines within three seconds."""

from robot_agent.motion.deadline_watch import DeadlineWatch

LATE, IN_TIME = 0.11, 0.1


def watch_of(*misses: float) -> DeadlineWatch:
    watch = DeadlineWatch()
    for t in misses:
        watch.update(t, LATE)
    return watch


def test_three_misses_within_three_seconds_are_an_overload():
    assert not watch_of(1.0, 2.0).overloaded(2.0)
    assert watch_of(1.0, 2.0, 3.9).overloaded(3.9)
    assert not watch_of(1.0, 2.0, 4.1).overloaded(4.1)


def test_overload_ends_when_the_first_miss_is_older():
    watch = watch_of(1.0, 1.5, 2.0)
    assert watch.overloaded(3.9)
    assert not watch.overloaded(4.0)
    watch.update(4.1, LATE)
    assert watch.overloaded(4.1)


def test_event_in_time_is_no_miss():
    watch = DeadlineWatch()
    for step in range(100):
        watch.update(0.01 * step, IN_TIME)
    assert watch.missed == 0
    assert not watch.overloaded(1.0)
