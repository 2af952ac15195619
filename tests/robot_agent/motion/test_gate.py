"""The safety gate: its cases, and its invariants."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from robot_agent.motion import gate
from robot_agent.motion.gate_limits import GateLimits
from robot_agent.motion.gate_reason import GateReason
from tests.robot_agent.motion.gate_cases import (
    CASES,
    DRIVE,
    STORIES,
    Case,
    fits,
    holds,
    inputs,
    run,
    stopping,
)


@pytest.mark.parametrize("case", CASES, ids=lambda c: f"{c.reason}-{c.requested}-{c.inputs}"[:70])
def test_case_of_the_table(case):
    decision = run(case)
    assert fits(case, decision), (decision, case.expected, case.reason)


@pytest.mark.parametrize("story", STORIES, ids=range(len(STORIES)))
def test_sequence_of_the_table(story):
    assert holds(story)


ARCS = [(0.35, 0.7), (0.2, -1.0), (0.1, 1.2), (0.5, 0.3)]


@pytest.mark.parametrize("requested", ARCS)
def test_an_obstacle_on_the_arc_slows_along_the_arc(requested):
    v, w = requested
    way = stopping(v)
    turn = way * w / v * 0.7
    middle = (math.sin(turn) * v / w, (1 - math.cos(turn)) * v / w)  # the axle's place at 70 %
    x, y = middle[0] + 0.21 * math.cos(turn), middle[1] + 0.21 * math.sin(turn)
    decision = run(Case(requested, (0, 0), inputs={"obstacles": [(x, y)]}))
    assert decision.reason == "obstacle"
    assert 0.0 <= decision.v < v
    if decision.v:
        assert decision.w / decision.v == pytest.approx(w / v)


def test_turns_round_beside_a_wall_at_patrol_distance():
    """Borders run 0.45 m from walls and the robot strays up to 0.05 m: it can turn round there."""
    wall = np.stack([np.linspace(-2, 2, 81), np.full(81, 0.40)], axis=1)
    for heading in np.linspace(0.0, math.tau, 73):
        c, s = math.cos(heading), math.sin(heading)
        seen = wall @ np.array([[c, -s], [s, c]])
        for w in (1.2, -1.2):
            decision = run(Case((0.0, w), (0.0, w), inputs={"obstacles": seen}))
            assert decision == gate.GateDecision(0.0, w, GateReason.NONE)


def test_follows_a_wall_at_patrol_distance_at_full_speed():
    wall = [(x, -0.40) for x in np.linspace(-2, 4, 121)]
    assert run(Case(DRIVE, DRIVE, inputs={"obstacles": wall})).v == 0.35


def test_denial_starts_again_from_standstill():
    tested = gate.SafetyGate(GateLimits())
    for k in range(10):
        tested.permit(0.1 * k, DRIVE, inputs(gate, 0.1 * k))
    assert tested.permit(1.0, DRIVE, inputs(gate, 1.0, stalled=True)).v == 0.0
    assert tested.permit(1.1, DRIVE, inputs(gate, 1.1)).v == 0.0
    assert tested.permit(1.2, DRIVE, inputs(gate, 1.2)).v == pytest.approx(0.025)


def body_hits(points, x, y, theta, settings):
    c, s = math.cos(theta), math.sin(theta)
    ahead_of = c * (points[:, 0] - x) + s * (points[:, 1] - y)
    aside = c * (points[:, 1] - y) - s * (points[:, 0] - x)
    return bool(
        (
            (ahead_of < settings.front)
            & (ahead_of > -settings.rear)
            & (np.abs(aside) < settings.half_width)
        ).any()
    )


@pytest.mark.parametrize("seed", range(5))
def test_a_turn_asked_for_again_and_again_does_not_creep_to_a_wall(seed: int) -> None:
    """Few points on the wall, 10 mm of noise, two minutes; the wall is 0.34 m beside the axle."""
    rng = np.random.default_rng(seed)
    limits = GateLimits()
    tested = gate.SafetyGate(limits)
    front, rear, side = limits.front, limits.rear, limits.half_width
    corners = np.array([(front, side), (front, -side), (-rear, side), (-rear, -side)])
    theta = w = 0.0
    for k in range(1200):
        c, s = math.cos(theta), math.sin(theta)
        wall = np.column_stack((np.linspace(-0.45, 0.45, 7), rng.normal(-0.34, 0.01, 7)))
        seen = wall @ np.array([[c, -s], [s, c]])
        w = tested.permit(0.1 * k, (0.0, 1.2), inputs(gate, 0.1 * k, obstacles=seen, w=w)).w
        theta += 0.1 * w
        nearest = float((corners @ np.array([math.sin(theta), math.cos(theta)])).min())
        assert nearest > -0.34, "the gap without more room: 27 mm too little"


@pytest.mark.parametrize(
    "seed", [*range(20), 87, 306, 502, 754, 1010, 1273, 2365, 2556, 2843, 3854]
)
def test_robot_never_touches_a_static_obstacle(seed):
    """Random requests among random posts; the base brakes as specified, one cycle late."""
    rng = np.random.default_rng(seed)
    settings = GateLimits()
    tested = gate.SafetyGate(settings)
    posts = rng.uniform(-2.5, 2.5, (40, 2))
    posts = posts[np.hypot(*posts.T) > 0.6]
    x = y = theta = v = w = 0.0
    pending = (0.0, 0.0)
    requested = (0.3, 0.0)
    for k in range(150):
        t = 0.1 * k
        if k % 12 == 0:
            requested = (
                float(rng.uniform(0, 0.6)),
                float(rng.uniform(-1.3, 1.3) * rng.integers(0, 2)),
            )
        c, s = math.cos(theta), math.sin(theta)
        seen = (posts - (x, y)) @ np.array([[c, -s], [s, c]])
        decision = tested.permit(t, requested, inputs(gate, t, obstacles=seen, v=v, w=w))
        assert 0.0 <= decision.v <= requested[0]
        assert abs(decision.w) <= max(abs(requested[1]), abs(pending[1]))
        for _ in range(5):
            v += min(max(pending[0] - v, -0.3 * 0.02), 0.3 * 0.02)
            w += min(max(pending[1] - w, -2.0 * 0.02), 2.0 * 0.02)
            x, y = x + v * 0.02 * math.cos(theta), y + v * 0.02 * math.sin(theta)
            theta += w * 0.02
            assert not body_hits(posts, x, y, theta, settings), t
        pending = (decision.v, decision.w)


@hypothesis_settings(max_examples=60)
@given(
    st.floats(),
    st.floats(),
    st.one_of(st.none(), st.floats()),
    st.one_of(st.none(), st.floats()),
    st.lists(st.tuples(st.floats(), st.floats()), max_size=4),
)
def test_any_input_gives_a_finite_command_no_larger_than_requested(v, w, base, scan, points):
    tested = gate.SafetyGate(GateLimits())
    for t in (0.0, 0.1, 0.2):
        decision = tested.permit(
            t, (v, w), inputs(gate, t, base_time=base, scan_time=scan, obstacles=points)
        )
        assert 0.0 <= decision.v <= max(v if math.isfinite(v) else 0.0, 0.0)
        assert abs(decision.w) <= (abs(w) if math.isfinite(w) else 0.0)
