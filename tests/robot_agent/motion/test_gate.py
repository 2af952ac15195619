"""The safety gate, case by case. The table is also what the mutation test runs."""

import math
from dataclasses import dataclass, field
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from robot_agent.motion import gate

WELL: dict[str, Any] = {
    "health": "localized",
    "motors_enabled": True,
    "stalled": False,
    "bumpers": 0,
    "v": 0.0,
    "w": 0.0,
    "obstacles": np.zeros((0, 2)),
}
STEPS = 10  # of 0.1 s, enough to reach any speed in the table
END = 1.0  # s, time of the last step


@dataclass(frozen=True)
class Case:
    """A wish held from standstill while all is well, and one last step with some inputs changed."""

    wish: tuple[float, float]
    expected: tuple[float, float]
    reason: str = "none"
    inputs: dict[str, Any] = field(default_factory=dict)
    last_wish: tuple[float, float] | None = None
    steps: int = STEPS
    settings: dict[str, float] = field(default_factory=dict)
    last_time: float = END


def run(case: Case, module: ModuleType = gate) -> Any:
    """Run a case on the gate of a module (the shipped one, or a mutant)."""
    tested = module.SafetyGate(module.GateSettings(**case.settings))
    for k in range(STEPS - case.steps, STEPS):
        t = 0.1 * k
        tested.permit(t, case.wish, inputs(module, t))
    t = case.last_time
    return tested.permit(t, case.last_wish or case.wish, inputs(module, t, **case.inputs))


def inputs(module: ModuleType, t: float, **changed: Any) -> Any:
    values = WELL | {"base_time": t - 0.1, "scan_time": t - 0.1} | changed
    if "obstacles" in changed:
        values["obstacles"] = np.array(changed["obstacles"], dtype=float).reshape(-1, 2)
    return module.GateInputs(**values)


def fits(case: Case, decision: Any) -> bool:
    close = all(
        math.isclose(a, b, abs_tol=1e-6)
        for a, b in zip((decision.v, decision.w), case.expected, strict=True)
    )
    return close and decision.reason == case.reason


def stopping(v: float, a: float = 0.3, delay: float = 0.25) -> float:
    return v * v / (2 * a) + v * delay


def stoppable(way: float, a: float = 0.3, delay: float = 0.25) -> float:
    return a * (math.sqrt(delay * delay + 2 * way / a) - delay)


def ahead(v: float, poses_free: int) -> float:
    """Speed permitted when so many of the 12 poses of the stopping way are free."""
    return stoppable(stopping(v) * poses_free / 12)


def turned(w: float, poses_free: int) -> float:
    return stoppable(stopping(w, 2.0) * poses_free / 12, 2.0)


FRONT = 0.41  # m ahead of the axle that are kept free
S = stopping(0.35)
R = stopping(0.3)


def met(pose: float, side: int, aside: float = 0.0) -> tuple[float, float]:
    """Where a point of the front margin is after that many twelfths of an arc of radius 0.5 m.

    aside: m from the front's middle, towards the centre of the arc.
    """
    angle = S / 0.5 * pose / 12
    x = 0.5 * math.sin(angle) + FRONT * math.cos(angle) - aside * math.sin(angle)
    y = 0.5 * (1 - math.cos(angle)) + FRONT * math.sin(angle) + aside * math.cos(angle)
    return x, side * y


def creeping(v: float) -> float:
    """Speed of which one twelfth of the stopping way permits v."""
    return stoppable(12 * stopping(v))


def post_after(v: float) -> tuple[float, float]:
    """A post that leaves one twelfth of that stopping way."""
    return FRONT + 1.5 * stopping(v), 0.0


POST = (-0.13, -0.36)  # what the rear corner meets in a left turn
DRIVE = (0.35, 0.0)
ZERO = (0.0, 0.0)


def denied(reason: str, **changed: Any) -> Case:
    return Case(DRIVE, ZERO, reason, changed)


def permitted(**changed: Any) -> Case:
    return Case(DRIVE, DRIVE, "none", changed)


CASES = [
    # nothing wrong
    Case(DRIVE, DRIVE),
    Case((0.35, 0.4), (0.35, 0.4)),
    Case((0.0, -1.2), (0.0, -1.2)),
    Case(ZERO, ZERO),
    # numbers that are none
    Case(DRIVE, ZERO, "invalid", last_wish=(math.nan, 0.0)),
    Case(DRIVE, ZERO, "invalid", last_wish=(0.1, math.inf)),
    denied("invalid", v=math.nan),
    denied("invalid", w=math.nan),
    denied("invalid", obstacles=[(math.nan, 3.0)]),
    denied("invalid", obstacles=[(5.0, math.inf)]),
    Case(DRIVE, ZERO, "invalid", last_time=math.nan),
    # ages
    denied("stale_base", base_time=None),
    denied("stale_base", base_time=END - 0.301),
    denied("stale_base", base_time=END + 0.01),
    denied("stale_base", base_time=math.nan),
    permitted(base_time=END - 0.299),
    permitted(base_time=END),
    denied("stale_laser", scan_time=None),
    denied("stale_laser", scan_time=END - 0.401),
    denied("stale_laser", scan_time=END + 0.01),
    permitted(scan_time=END - 0.399),
    permitted(scan_time=END),
    Case(DRIVE, ZERO, "stale_base", {"base_time": END - 0.5}, settings={"max_base_age": 0.5}),
    Case(DRIVE, ZERO, "stale_laser", {"scan_time": END - 0.5}, settings={"max_scan_age": 0.5}),
    Case(DRIVE, DRIVE, "none", {"base_time": END - 0.45}, settings={"max_base_age": 0.5}),
    Case(DRIVE, DRIVE, "none", {"scan_time": END - 0.45}, settings={"max_scan_age": 0.5}),
    # states
    denied("not_localized", health="lost"),
    denied("not_localized", health=None),
    denied("not_localized", health="splendid"),
    denied("motors_off", motors_enabled=False),
    denied("stalled", stalled=True),
    denied("bumper", bumpers=1),
    denied("bumper", bumpers=16),
    denied("overspeed", v=0.71),
    denied("overspeed", v=-0.71),
    permitted(v=0.69),
    permitted(v=-0.69),
    denied("overspeed", w=1.71),
    denied("overspeed", w=-1.71),
    permitted(w=1.69),
    Case(DRIVE, ZERO, "backing", last_wish=(-0.01, 0.3)),
    Case((0.0, 0.5), (0.0, 0.5), last_wish=(0.0, 0.5)),
    # the first reason is the one told
    denied("stale_base", base_time=None, scan_time=None, health="lost"),
    denied("stale_laser", scan_time=None, health="lost"),
    denied("not_localized", health="lost", motors_enabled=False),
    denied("motors_off", motors_enabled=False, stalled=True),
    denied("stalled", stalled=True, bumpers=1),
    # speed limits, along the wished arc
    Case((0.7, 0.0), (0.5, 0.0), "speed_limit"),
    Case((0.5, 0.0), (0.5, 0.0)),
    Case((1.0, 0.8), (0.5, 0.4), "speed_limit"),
    Case((0.0, 3.0), (0.0, 1.5), "speed_limit"),
    Case((0.3, -3.0), (0.15, -1.5), "speed_limit"),
    Case((0.0, 1.5), (0.0, 1.5)),
    Case((0.3, 0.4), (0.15, 0.2), "unsure", {"health": "unsure"}),
    Case((0.15, 0.4), (0.15, 0.4), "none", {"health": "unsure"}),
    Case((0.0, 1.2), (0.0, 1.2), "none", {"health": "unsure"}),
    Case(
        (0.3, 0.0),
        (0.2, 0.0),
        "unsure",
        {"health": "unsure"},
        settings={"max_speed": 0.2, "unsure_speed": 0.4},
    ),
    # the limited mode needs no pose, but is slow; nothing else is given up
    Case((0.3, 0.4), (0.15, 0.2), "limited", {"limited": True, "health": None}),
    Case((0.3, 0.4), (0.15, 0.2), "limited", {"limited": True, "health": "lost"}),
    Case((0.3, 0.4), (0.15, 0.2), "limited", {"limited": True}),
    Case((0.3, 0.4), (0.15, 0.2), "limited", {"limited": True, "health": "unsure"}),
    Case((0.15, 0.5), (0.15, 0.5), "none", {"limited": True, "health": None}),
    Case((0.0, -1.0), (0.0, -0.8), "limited", {"limited": True, "health": None}),
    Case((0.0, -0.6), (0.0, -0.5), "limited", {"limited": True, "health": None}),
    Case((0.0, 0.6), (0.0, 0.5), "limited", {"limited": True, "health": None}),
    Case(
        (0.0, 0.6),
        (0.0, 0.4),
        "limited",
        {"limited": True},
        settings={"max_turn_rate": 0.4},
    ),
    denied("stale_base", limited=True, base_time=None),
    denied("stale_laser", limited=True, scan_time=None),
    denied("motors_off", limited=True, motors_enabled=False),
    denied("stalled", limited=True, stalled=True),
    denied("bumper", limited=True, bumpers=2),
    denied("overspeed", limited=True, v=0.71),
    Case(DRIVE, ZERO, "backing", {"limited": True}, last_wish=(-0.01, 0.3)),
    Case(DRIVE, ZERO, "obstacle", {"limited": True, "obstacles": [(0.25, 0.1)]}),
    # getting faster
    Case(DRIVE, (0.0, 0.0), "acceleration", steps=0),
    Case(DRIVE, (0.05, 0.0), "acceleration", steps=1),
    Case(DRIVE, (0.10, 0.0), "acceleration", steps=2),
    Case((0.0, 1.2), (0.0, 0.2), "acceleration", steps=1),
    Case((0.0, -1.2), (0.0, -0.2), "acceleration", steps=1),
    Case(DRIVE, (0.15, 0.0), "acceleration", steps=1, last_time=9.0),
    Case(DRIVE, (0.0, 0.0), "acceleration", steps=1, last_time=0.8),
    Case((0.0, 1.0), (0.0, 0.8), "acceleration", last_wish=(0.0, -1.2)),
    Case((0.7, 0.0), (0.05, 0.0), "speed_limit", steps=1),
    # turning follows the base both ways; driving slower is never delayed
    Case(DRIVE, (0.1, 0.0), last_wish=(0.1, 0.0)),
    Case(DRIVE, ZERO, last_wish=ZERO),
    Case((0.0, 1.2), (0.0, 1.0), "acceleration", last_wish=(0.0, 0.1)),
    Case((0.0, -1.2), (0.0, -1.0), "acceleration", last_wish=ZERO),
    Case((0.0, 1.2), (0.0, 1.1), last_wish=(0.0, 1.1)),
    # an obstacle ahead: front 0.21 + front margin 0.20, and the stopping way
    Case(DRIVE, DRIVE, "none", {"obstacles": [(0.4101 + S, 0.0)]}),
    Case(DRIVE, (ahead(0.35, 11), 0.0), "obstacle", {"obstacles": [(0.4099 + S, 0.0)]}),
    Case(DRIVE, (ahead(0.35, 5), 0.0), "obstacle", {"obstacles": [(0.4099 + S / 2, 0.0)]}),
    Case(DRIVE, (ahead(0.35, 6), 0.0), "obstacle", {"obstacles": [(0.4101 + S / 2, 0.0)]}),
    Case(DRIVE, (ahead(0.35, 1), 0.0), "obstacle", {"obstacles": [(0.4101 + S / 12, 0.0)]}),
    Case(DRIVE, ZERO, "obstacle", {"obstacles": [(0.4099 + S / 12, 0.0)]}),
    Case(DRIVE, ZERO, "obstacle", {"obstacles": [(0.25, 0.1)]}),
    Case(DRIVE, (ahead(0.35, 5), 0.0), "obstacle", {"obstacles": [(9, 9), (0.4099 + S / 2, 0.1)]}),
    # beside the way: half width 0.2125 + margin 0.08
    Case(DRIVE, DRIVE, "none", {"obstacles": [(0.4, 0.2926), (0.4, -0.2926)]}),
    Case(DRIVE, ZERO, "obstacle", {"obstacles": [(0.3, 0.2924)]}),
    Case(DRIVE, ZERO, "obstacle", {"obstacles": [(0.3, -0.2924)]}),
    # beside the body a wall may be nearer than the margin, if the way comes no nearer
    Case(DRIVE, DRIVE, "none", {"obstacles": [(0.0, 0.25), (0.3, 0.251)]}),
    Case(DRIVE, ZERO, "obstacle", {"obstacles": [(0.0, 0.25), (0.3, 0.249)]}),
    Case(DRIVE, DRIVE, "none", {"obstacles": [(-0.29, -0.25), (0.3, 0.251)]}),
    Case(DRIVE, ZERO, "obstacle", {"obstacles": [(-0.31, -0.25), (0.3, 0.251)]}),
    Case(DRIVE, ZERO, "obstacle", {"obstacles": [(0.211, 0.25), (0.3, 0.251)]}),
    Case(DRIVE, ZERO, "obstacle", {"obstacles": [(0.0, 0.22)]}),  # nearer than the turn margin
    # behind
    Case(DRIVE, DRIVE, "none", {"obstacles": [(-0.33, 0.0), (-2.0, 0.0)]}),
    Case(DRIVE, ZERO, "obstacle", {"obstacles": [(-0.29, 0.0)]}),
    # arcs are swept, not straight ahead
    Case((0.35, 0.7), (0.35, 0.7), "none", {"obstacles": [(0.55, -0.25)]}),
    Case((0.35, -0.7), (0.35, -0.7), "none", {"obstacles": [(0.55, 0.25)]}),
    # turning on the spot: reach of the front corner 0.315, of the rear corner 0.397
    Case((0.0, 1.2), (0.0, 1.2), "none", {"obstacles": [(0.0, 0.40), (0.0, -0.40), (0.4, 0.0)]}),
    # the post meets the right side after asin(0.2325 / 0.3827) of a turn, between poses 10 and 11
    Case((0.0, 1.2), (0.0, turned(1.2, 10)), "obstacle", {"obstacles": [POST]}),
    Case((0.0, -1.2), (0.0, -turned(1.2, 10)), "obstacle", {"obstacles": [(-0.13, 0.36)]}),
    Case((0.0, 1.2), ZERO, "obstacle", {"obstacles": [(0.0, 0.23)]}),
    Case((0.0, 1.2), (0.0, 1.2), "none", {"obstacles": [(0.33, 0.0)]}),
    Case((0.0, 1.2), ZERO, "obstacle", {"obstacles": [(0.222, 0.0)]}),
    # blocked ahead it may still turn
    Case((0.2, 0.8), (0.0, 0.8), "obstacle", {"obstacles": [(0.27, 0.0)]}),
    Case((0.2, -0.8), (0.0, -0.8), "obstacle", {"obstacles": [(0.27, 0.0)]}),
    # the base still rolls or turns faster than wished
    Case((0.1, 0.0), (0.1, 0.0), "none", {"v": 0.3, "obstacles": [(0.4101 + R, 0.0)]}),
    Case((0.1, 0.0), (0.1, 0.0), "none", {"v": 0.3, "obstacles": [(0.4099 + R, 0.0)]}),
    Case(
        (0.3, 0.0),
        (stoppable(R * 11 / 12), 0.0),
        "obstacle",
        {"v": 0.3, "obstacles": [(0.4099 + R, 0)]},
    ),
    Case((0.3, 0.3), ZERO, "obstacle", {"v": 0.3, "obstacles": [(0.3, 0.0)]}),
    Case((0.1, 0.3), ZERO, "obstacle", {"v": 0.3, "obstacles": [(0.3, 0.0)]}),
    Case((0.0, 0.6), ZERO, "obstacle", {"v": 0.3, "obstacles": [(0.3, 0.0)]}),
    Case((0.0, 0.6), (0.0, 0.6), "none", {"obstacles": [POST]}),
    Case((0.0, 0.6), (0.0, 0.6), "none", {"w": -1.2, "obstacles": [POST]}),
    Case((0.0, 1.2), (0.0, turned(1.2, 10)), "obstacle", {"w": -1.4, "obstacles": [POST]}),
    Case((0.0, 1.1), (0.0, turned(1.2, 10)), "obstacle", {"w": 1.2, "obstacles": [POST]}),
    Case(DRIVE, DRIVE, "none", {"w": 1.2, "obstacles": [(0.4, 0.2926), (0.4, -0.2926)]}),
    # on an arc: what the front meets between two poses
    Case(
        (0.35, 0.7), (ahead(0.35, 6), ahead(0.35, 6) * 2), "obstacle", {"obstacles": [met(6.5, 1)]}
    ),
    Case(
        (0.35, -0.7),
        (ahead(0.35, 6), -ahead(0.35, 6) * 2),
        "obstacle",
        {"obstacles": [met(6.5, -1)]},
    ),
    Case(
        (0.35, 0.7),
        (ahead(0.35, 10), ahead(0.35, 10) * 2),
        "obstacle",
        {"obstacles": [met(10.9, 1)]},
    ),
    Case(
        (0.35, 0.7),
        (ahead(0.35, 11), ahead(0.35, 11) * 2),
        "obstacle",
        {"obstacles": [met(11.1, 1)]},
    ),
    Case(
        (0.35, 0.7),
        (ahead(0.35, 6), ahead(0.35, 6) * 2),
        "obstacle",
        {"obstacles": [met(6.05, 1, 0.28)]},
    ),
    Case(
        (0.35, -0.7),
        (ahead(0.35, 6), -ahead(0.35, 6) * 2),
        "obstacle",
        {"obstacles": [met(6.05, -1, 0.28)]},
    ),
    Case(
        (0.35, 0.7),
        (ahead(0.35, 10), ahead(0.35, 10) * 2),
        "obstacle",
        {"obstacles": [met(10.99, 1)]},
    ),
    Case(
        (0.35, 0.7),
        (ahead(0.35, 11), ahead(0.35, 11) * 2),
        "obstacle",
        {"obstacles": [met(11.01, 1)]},
    ),
    # slower than creeping is no progress
    Case((creeping(0.021), 0.0), (0.021, 0.0), "obstacle", {"obstacles": [post_after(0.021)]}),
    Case((creeping(0.019), 0.0), ZERO, "obstacle", {"obstacles": [post_after(0.019)]}),
    Case((0.021, 1.2), ZERO, "obstacle", {"obstacles": [(0.0, 0.2315)]}),
    # the turn margin
    Case((0.0, 1.2), ZERO, "obstacle", {"obstacles": [(0.0, 0.2315)]}),
    Case((0.0, 1.2), (0.0, turned(1.2, 1)), "obstacle", {"obstacles": [(0.0, 0.2335)]}),
    Case((0.019, 1.2), (0.0, turned(1.2, 1)), "obstacle", {"obstacles": [(0.0, 0.2335)]}),
    Case(
        (0.0, 0.6),
        (0.0, stoppable(stopping(0.8, 2.0) / 4, 2.0)),
        "obstacle",
        {"w": 0.8, "obstacles": [(0.0, 0.2335)]},
    ),
    Case(
        (0.35, 0.7),
        (ahead(0.35, 10), ahead(0.35, 10) * 2),
        "obstacle",
        {"obstacles": [met(10.5, 1, -0.2)]},
    ),
    # exactly on a limit
    permitted(v=0.7),
    permitted(w=1.7),
    Case((0.0, 1.2), (0.0, 1.2), settings={"creep_speed": 0.0}),
    Case(
        (0.2, 0.8),
        (0.0, 0.8),
        "obstacle",
        {"obstacles": [(0.27, 0.0)]},
        settings={"creep_speed": 0.0},
    ),
    Case(DRIVE, ZERO, "obstacle", {"obstacles": [(0.21, 0.25), (0.3, 0.251)]}),
    Case(DRIVE, ZERO, "obstacle", {"obstacles": [(-0.301, 0.25), (0.3, 0.251)]}),
    # an obstacle is told before a speed limit
    Case((0.7, 0.0), ZERO, "obstacle", {"obstacles": [(0.25, 0.0)]}),
]


@pytest.mark.parametrize("case", CASES, ids=lambda c: f"{c.reason}-{c.wish}-{c.inputs}"[:70])
def test_case(case):
    decision = run(case)
    assert fits(case, decision), (decision, case.expected, case.reason)


ARCS = [(0.35, 0.7), (0.2, -1.0), (0.1, 1.2), (0.5, 0.3)]


@pytest.mark.parametrize("wish", ARCS)
def test_an_obstacle_on_the_arc_slows_along_the_arc(wish):
    v, w = wish
    way = stopping(v)
    turn = way * w / v * 0.7
    middle = (math.sin(turn) * v / w, (1 - math.cos(turn)) * v / w)  # the axle's place at 70 %
    x, y = middle[0] + 0.21 * math.cos(turn), middle[1] + 0.21 * math.sin(turn)
    decision = run(Case(wish, (0, 0), inputs={"obstacles": [(x, y)]}))
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
            assert decision == gate.GateDecision(0.0, w, gate.GateReason.NONE)


def test_follows_a_wall_at_patrol_distance_at_full_speed():
    wall = [(x, -0.40) for x in np.linspace(-2, 4, 121)]
    assert run(Case(DRIVE, DRIVE, inputs={"obstacles": wall})).v == 0.35


def test_denial_starts_again_from_standstill():
    tested = gate.SafetyGate(gate.GateSettings())
    for k in range(10):
        tested.permit(0.1 * k, DRIVE, inputs(gate, 0.1 * k))
    assert tested.permit(1.0, DRIVE, inputs(gate, 1.0, stalled=True)).v == 0.0
    assert tested.permit(1.1, DRIVE, inputs(gate, 1.1)).v == 0.0
    assert tested.permit(1.2, DRIVE, inputs(gate, 1.2)).v == pytest.approx(0.05)


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


@pytest.mark.parametrize(
    "seed", [*range(20), 87, 306, 502, 754, 1010, 1273, 2365, 2556, 2843, 3854]
)
def test_never_touches_a_still_obstacle(seed):
    """Random wishes among random posts; the base brakes as promised, one cycle late."""
    rng = np.random.default_rng(seed)
    settings = gate.GateSettings()
    tested = gate.SafetyGate(settings)
    posts = rng.uniform(-2.5, 2.5, (40, 2))
    posts = posts[np.hypot(*posts.T) > 0.6]
    x = y = theta = v = w = 0.0
    pending = (0.0, 0.0)
    wish = (0.3, 0.0)
    for k in range(150):
        t = 0.1 * k
        if k % 12 == 0:
            wish = (float(rng.uniform(0, 0.6)), float(rng.uniform(-1.3, 1.3) * rng.integers(0, 2)))
        c, s = math.cos(theta), math.sin(theta)
        seen = (posts - (x, y)) @ np.array([[c, -s], [s, c]])
        decision = tested.permit(t, wish, inputs(gate, t, obstacles=seen, v=v, w=w))
        assert 0.0 <= decision.v <= wish[0]
        assert abs(decision.w) <= max(abs(wish[1]), abs(pending[1]))
        for _ in range(5):
            v += min(max(pending[0] - v, -0.3 * 0.02), 0.3 * 0.02)
            w += min(max(pending[1] - w, -2.0 * 0.02), 2.0 * 0.02)
            x, y = x + v * 0.02 * math.cos(theta), y + v * 0.02 * math.sin(theta)
            theta += w * 0.02
            assert not body_hits(posts, x, y, theta, settings), t
        pending = (decision.v, decision.w)


@hypothesis_settings(max_examples=60, deadline=None)
@given(
    st.floats(),
    st.floats(),
    st.one_of(st.none(), st.floats()),
    st.one_of(st.none(), st.floats()),
    st.lists(st.tuples(st.floats(), st.floats()), max_size=4),
)
def test_any_input_gives_a_finite_command_no_larger_than_wished(v, w, base, scan, points):
    tested = gate.SafetyGate(gate.GateSettings())
    for t in (0.0, 0.1, 0.2):
        decision = tested.permit(
            t, (v, w), inputs(gate, t, base_time=base, scan_time=scan, obstacles=points)
        )
        assert 0.0 <= decision.v <= max(v if math.isfinite(v) else 0.0, 0.0)
        assert abs(decision.w) <= (abs(w) if math.isfinite(w) else 0.0)
