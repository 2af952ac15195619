"""The heading loop: steering, turning in place, limits, pins."""

import math

import pytest

from robot_agent.motion.heading_loop import HeadingLoop

DT = 0.1


def settled(velocity, theta, curvature=0.0, *, loop=None, steps=40, start=0.0):
    """The command after a while of the same request and heading."""
    loop = loop or HeadingLoop()
    return [loop.command(start + DT * k, velocity, theta, curvature) for k in range(steps)][-1]


def toward(angle, speed=0.35):
    return speed * math.cos(angle), speed * math.sin(angle)


def test_aligned_velocity_drives_straight_at_its_speed():
    assert settled((0.35, 0.0), 0.0) == pytest.approx((0.35, 0.0))


@pytest.mark.parametrize("error", [0.2, -0.2])
def test_small_error_steers_while_driving(error):
    v, w = settled(toward(1.0 + error), 1.0)
    assert v == pytest.approx(0.35 * math.cos(error))
    assert w == pytest.approx(math.copysign(math.sqrt(2.0 * 0.2), error))  # the braking bound
    v, w = settled(toward(1.0 + error / 4), 1.0)
    assert w == pytest.approx(4.0 * error / 4)  # k e


def test_curvature_of_the_path_is_fed_forward():
    v, w = settled((0.35, 0.0), 0.0, 0.5)
    assert (v, w) == pytest.approx((0.35, 0.175))


def test_first_command_is_standstill_and_acceleration_is_limited():
    loop = HeadingLoop()
    assert loop.command(0.0, (0.35, 0.0), 0.0) == (0.0, 0.0)
    assert loop.command(0.1, (0.35, 0.0), 0.0) == pytest.approx((0.03, 0.0))
    v, w = loop.command(0.2, (0.35, 0.0), -0.9)
    assert v == pytest.approx(0.06)
    assert w == pytest.approx(0.2)


def test_zero_velocity_stops_the_robot():
    assert settled((0.0, 0.0), 1.0) == (0.0, 0.0)
    assert settled((0.004, 0.0), 3.0) == (0.0, 0.0)


def turning(errors):
    """Commands while the heading error takes these values, from standstill."""
    loop = HeadingLoop()
    return [loop.command(DT * k, toward(e), 0.0) for k, e in enumerate(errors)]


def test_large_error_turns_in_place():
    v, w = settled(toward(2.0), 0.0)
    assert v == 0.0
    assert w == pytest.approx(1.2)


def test_just_below_the_turn_angle_it_drives():
    v, w = settled(toward(math.radians(59.0)), 0.0)
    assert v == pytest.approx(0.35 * math.cos(math.radians(59.0)))
    assert w == pytest.approx(1.2)


def test_hysteresis_turns_on_until_the_resume_angle():
    errors = [math.radians(d) for d in [70] * 5 + [50] * 5 + [16] * 5 + [14] * 5]
    v = [command[0] for command in turning(errors)]
    assert max(v[:15]) == 0.0
    assert v[15] > 0.0


def test_turn_side_is_kept_through_the_opposite_heading():
    """The error flips between +180 and -180 degrees; the turn goes on."""
    for first in (1.0, -1.0):
        errors = [first * 3.1] * 10 + [-first * 3.1] * 10 + [-first * 2.0] * 5
        w = [command[1] for command in turning(errors)]
        assert all(x * first > 0.0 for x in w[1:])


def test_next_turn_chooses_its_side_again():
    errors = [2.0] * 5 + [0.1] * 10 + [-2.0] * 20
    w = [command[1] for command in turning(errors)]
    assert w[4] > 0.0
    assert w[-1] == pytest.approx(-1.2)


def test_brakes_along_the_path_before_it_turns():
    loop = HeadingLoop()
    settled((0.35, 0.0), 0.0, 0.5, loop=loop)
    found = [loop.command(4.0 + DT * k, (-0.35, 0.0), 0.0, -0.5) for k in range(20)]
    for v, w in found:
        if v > 0.06:
            assert w == pytest.approx(v * 0.5, abs=0.02)  # still on the arc it is leaving
    assert found[-1] == pytest.approx((0.0, 1.2))


def test_approach_to_a_heading_can_be_braked():
    """Turning rate never exceeds what turn_braking stops within the error left."""
    theta, loop = 0.0, HeadingLoop()
    pending = 0.0
    for k in range(60):
        _, w = loop.command(DT * k, toward(3.0), theta)
        theta, pending = theta + pending * DT, w
    assert theta == pytest.approx(3.0, abs=0.02)
