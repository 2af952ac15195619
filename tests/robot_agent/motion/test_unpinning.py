"""The manoeuvre out of a place where obstacles pin the robot, joined to the heading loop."""

import math

import numpy as np
import pytest

from robot_agent.motion import gate
from robot_agent.motion.footprint import Footprint
from robot_agent.motion.gate_hold import pinned_by_obstacle
from robot_agent.motion.gate_limits import GateLimits
from robot_agent.motion.heading_loop import HeadingLoop
from robot_agent.motion.unpinning import UnpinningManoeuvre
from tests.robot_agent.motion.gate_cases import inputs

DT = 0.1


def toward(angle, speed=0.35):
    return speed * math.cos(angle), speed * math.sin(angle)


class Loop:
    """The heading loop with the manoeuvre, as the agent joins them."""

    def __init__(self):
        self.loop, self.unpinning = HeadingLoop(), UnpinningManoeuvre()
        self.edges = False

    def command(self, t, velocity, theta, *, pinned=False):
        override = self.unpinning.step(t, self.loop.turn, pinned=pinned)
        self.edges = override.edges
        return self.loop.command(t, velocity, theta, 0.0, override)


def pinned_turn(times, theta=0.0, error=1.3):
    """Turning rates over 6 s while an obstacle pins the robot from and to each pair of times, s."""
    loop, rates = Loop(), []
    for k in range(60):
        t = DT * k
        pinned = any(begin <= t < end for begin, end in times)
        rates.append(loop.command(t, toward(error), theta, pinned=pinned)[1])
    return rates


def test_pinned_for_a_second_turns_the_other_way():
    rates = pinned_turn([(0.5, 2.0)])
    assert all(w > 0.0 for w in rates[1:15])
    assert all(w < 0.0 for w in rates[30:])  # all the way round


def test_pinned_for_less_than_a_second_continues():
    assert all(w > 0.0 for w in pinned_turn([(0.5, 1.4), (1.6, 2.5)])[1:])


def test_pinned_on_both_sides_alternates():
    rates = pinned_turn([(0.5, 6.0)])
    assert min(rates) < 0.0 < max(rates[30:])


def test_third_pin_of_a_turn_edges_straight_ahead():
    loop = Loop()
    steps = [loop.command(DT * k, toward(1.3), 0.0, pinned=k >= 5) for k in range(80)]
    edging = [k for k, (v, _) in enumerate(steps) if v > 0.05]
    assert edging[0] * DT > 3.0  # three times its patience
    assert max(v for v, _ in steps) == pytest.approx(0.1)
    assert (edging[-1] - edging[0]) * DT == pytest.approx(1.5, abs=0.3)
    assert steps[edging[5]] == (pytest.approx(0.1), pytest.approx(0.0))
    assert max(abs(w) for _, w in steps[edging[-1] :]) > 0.5  # and tries to turn again


def test_pinned_while_edging_ahead_turns_to_the_other_side_next():
    """Pinned throughout: of two attempts to edge ahead, one comes after each side."""
    loop, sides = Loop(), []
    w_before = v_before = 0.0
    for k in range(250):
        v, w = loop.command(DT * k, toward(1.3), 0.0, pinned=k >= 5)
        if v > 0.0 >= v_before:
            sides.append(math.copysign(1.0, w_before))
        v_before = v
        w_before = w or w_before
    assert sides[:4] == [1.0, -1.0, 1.0, -1.0]


def test_after_edging_ahead_turns_the_shorter_way():
    loop = Loop()
    edged = [loop.command(DT * k, toward(1.3), 0.0, pinned=5 <= k < 42)[0] > 0.0 for k in range(80)]
    assert any(edged)
    assert loop.command(8.0, toward(1.3), 0.0)[1] > 0.5


def test_reaching_the_heading_resets_the_pins():
    """In each period of 6 s: pinned for 2 s, so once; then aligned, and turned away again."""
    loop, speeds = Loop(), []
    for k in range(300):
        pinned, theta = 10 < k % 60 < 30, 1.3 if k % 60 > 50 else 0.0
        v, _ = loop.command(DT * k, toward(1.3), theta, pinned=pinned)
        if 25 < k % 60 < 50:
            speeds.append(v)
    assert max(speeds) == pytest.approx(0.0, abs=1e-9)


def test_pinned_without_a_turn_rate_keeps_the_side():
    assert pinned_turn([(0.5, 6.0)], error=0.0) == pytest.approx([0.0] * 60)


def test_pinned_with_a_small_error_turns_the_other_way_round():
    rates = pinned_turn([(0.5, 2.0)], error=0.6)
    assert rates[10] > 0.0 > rates[30]


def test_pinned_at_its_heading_edges_ahead_and_then_tries_the_heading_again():
    loop, edging = Loop(), []
    for k in range(60):
        loop.command(DT * k, toward(0.1), 0.0, pinned=k >= 5)
        edging.append(loop.edges)
    begin, end = edging.index(True), edging.index(False, edging.index(True))
    assert begin * DT == pytest.approx(1.5, abs=0.15)  # after a second
    assert (end - begin) * DT == pytest.approx(1.5, abs=0.15)
    assert (edging.index(True, end) - end) * DT == pytest.approx(1.0, abs=0.15)


def test_edging_at_the_heading_ends_when_the_robot_is_to_turn_back():
    loop = Loop()
    for k in range(25):
        loop.command(DT * k, toward(0.1), 0.0, pinned=k >= 5)
    assert loop.edges
    for k in range(25, 33):
        _, w = loop.command(DT * k, toward(2.8), 0.0, pinned=False)
    assert not loop.edges
    assert w > 0.2


@pytest.mark.parametrize("side", [-1, 1])
def test_robot_turned_in_a_door_with_no_room_to_correct_its_heading_gets_through(side):
    limits = GateLimits(half_width=0.34, front=0.37, rear=0.54, turn_margin=0.034)
    body = Footprint(limits)
    wall = np.linspace(0.0, 0.15, 4)
    frame = np.array([(x, y) for x in wall for y in (-0.39, 0.39)])
    loop, tested = Loop(), gate.SafetyGate(limits)
    x, y, theta, v, w = -0.1, 0.0, 0.09 * side, 0.0, 0.0
    decision = None
    for k in range(400):
        c, s = math.cos(theta), math.sin(theta)
        seen = (frame - (x, y)) @ np.array([[c, -s], [s, c]])
        assert not body.covers(seen).any()
        pinned = pinned_by_obstacle(decision)
        requested = loop.command(DT * k, toward(0.08 * side), theta, pinned=pinned)
        decision = tested.permit(DT * k, requested, inputs(gate, DT * k, obstacles=seen, v=v, w=w))
        x, y, theta = x + DT * v * c, y + DT * v * s, theta + DT * w
        v, w = decision.v, decision.w
    assert x > 1.0
