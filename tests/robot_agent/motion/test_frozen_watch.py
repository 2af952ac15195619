"""A sensor that repeats itself while the robot moves is frozen."""

from robot_agent.motion.frozen_watch import FrozenWatch


def test_frozen_after_repeats_while_moving_until_a_reading_differs():
    watch = FrozenWatch(2)
    seen = []
    for reading in (b"a", b"a", b"a", b"a", b"b", b"b", b"c"):
        watch.update(reading, moving=True)
        seen.append(watch.frozen)
    assert seen == [False, False, True, True, False, False, False]


def test_repeated_readings_at_rest_are_not_frozen():
    watch = FrozenWatch(2)
    for _ in range(10):
        watch.update(b"a", moving=False)
    assert not watch.frozen


def test_standing_still_does_not_clear_a_frozen_sensor():
    watch = FrozenWatch(1)
    watch.update(b"a", moving=True)
    watch.update(b"a", moving=True)
    watch.update(b"a", moving=False)
    assert watch.frozen
