"""Table of cases for the safety gate; every mutant of the gate must fail one of them."""

import math
from dataclasses import dataclass, field
from types import ModuleType
from typing import Any

import numpy as np

from robot_agent.motion import gate
from robot_agent.motion.field_of_view import FieldOfView

WELL: dict[str, Any] = {
    "health": "localized",
    "body_known": True,
    "charging": False,
    "motors_enabled": True,
    "stop_button": False,
    "stalled": False,
    "bumpers": 0,
    "battery": 12.6,
    "v": 0.0,
    "w": 0.0,
    "obstacles": np.zeros((0, 2)),
    "views": (FieldOfView(0.017, 0.008, 0.0, math.pi / 2, math.inf),),
}
STEPS = 12  # of 0.1 s, enough to reach any speed in the table
END = 1.2  # s, time of the last step


@dataclass(frozen=True)
class Case:
    """A request held from standstill with good inputs, and a last step with other inputs."""

    requested: tuple[float, float]
    expected: tuple[float, float]
    reason: str = "none"
    inputs: dict[str, Any] = field(default_factory=dict)
    last_requested: tuple[float, float] | None = None
    steps: int = STEPS
    settings: dict[str, float] = field(default_factory=dict)
    last_time: float = END


def run(case: Case, module: ModuleType = gate) -> Any:
    """Run a case on the gate of a module (the shipped one, or a mutant)."""
    tested = module.SafetyGate(module.GateLimits(**case.settings))
    for k in range(STEPS - case.steps, STEPS):
        t = 0.1 * k
        tested.permit(t, case.requested, inputs(module, t))
    t = case.last_time
    return tested.permit(t, case.last_requested or case.requested, inputs(module, t, **case.inputs))


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
    """Position of a point of the front margin after so many twelfths of an arc of radius 0.5 m.

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


SIDES = (0.2925, 0.0, -0.2925)  # m: half the width and the margin beside, left, middle, right


CORNER = math.atan2(SIDES[0], FRONT + S)  # rad, bearing of the front edge's end
FAR_CORNER = math.hypot(SIDES[0], FRONT + S)  # m


def spots(*places: tuple[float, float]) -> dict[str, Any]:
    """Sensors that see nothing but these positions."""
    return {"views": tuple(FieldOfView(x, y, 0.0, math.pi, 0.001) for x, y in places)}


def fan(theta: float, half_angle: float, reach: float = 9.0) -> dict[str, Any]:
    return {"views": (FieldOfView(0.0, 0.0, theta, half_angle, reach),)}


def edge(way: float) -> list[tuple[float, float]]:
    """The front edge, margins included, after a way straight ahead."""
    return [(FRONT + way, aside) for aside in SIDES]


EDGE = (0.1, 0.0)
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
    Case((0.2, 0.3), (0.2, 0.3), inputs={"v": 0.4}),  # it still rolls faster
    Case((0.2, 0.3), (0.2, 0.3), inputs={"v": 0.4, "obstacles": [(0.0, -0.9)]}),
    Case(ZERO, ZERO),
    # numbers that are none
    Case(DRIVE, ZERO, "invalid", last_requested=(math.nan, 0.0)),
    Case(DRIVE, ZERO, "invalid", last_requested=(0.1, math.inf)),
    denied("invalid", v=math.nan),
    denied("invalid", w=math.nan),
    denied("invalid", battery=math.nan),
    denied("invalid", obstacles=[(math.nan, 3.0)]),
    denied("invalid", obstacles=[(5.0, math.inf)]),
    Case(DRIVE, ZERO, "invalid", last_time=math.nan),
    # ages
    denied("stale_base", base_time=None),
    denied("stale_base", base_time=END - 0.281),
    denied("stale_base", base_time=END + 0.01),
    denied("stale_base", base_time=math.nan),
    permitted(base_time=END - 0.279),
    permitted(base_time=END),
    denied("stale_laser", scan_time=None),
    denied("stale_laser", scan_time=END - 0.341),
    denied("stale_laser", scan_time=END + 0.01),
    permitted(scan_time=END - 0.339),
    permitted(scan_time=END),
    Case(DRIVE, ZERO, "stale_base", {"base_time": END - 0.5}, settings={"max_base_age": 0.5}),
    Case(DRIVE, ZERO, "stale_laser", {"scan_time": END - 0.5}, settings={"max_scan_age": 0.5}),
    Case(DRIVE, DRIVE, "none", {"base_time": END - 0.45}, settings={"max_base_age": 0.5}),
    Case(DRIVE, DRIVE, "none", {"scan_time": END - 0.45}, settings={"max_scan_age": 0.5}),
    # states
    denied("not_localized", health="lost"),
    denied("not_localized", health=None),
    denied("not_localized", health="splendid"),
    denied("body_unknown", body_known=False),
    denied("overloaded", overloaded=True),
    denied("laser_mount", laser_denied=True),
    denied("motors_off", motors_enabled=False),
    denied("stop_button", stop_button=True),
    denied("charging", charging=True),
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
    Case(DRIVE, ZERO, "backing", last_requested=(-0.01, 0.3)),
    Case((0.0, 0.5), (0.0, 0.5), last_requested=(0.0, 0.5)),
    # the first reason is the one told
    denied("stale_base", base_time=None, scan_time=None, health="lost"),
    denied("stale_laser", scan_time=None, health="lost"),
    denied("body_unknown", body_known=False, overloaded=True),
    denied("overloaded", overloaded=True, health="lost"),
    denied("overloaded", overloaded=True, laser_denied=True),
    denied("laser_mount", laser_denied=True, health="lost"),
    denied("laser_mount", limited=True, laser_denied=True),
    denied("not_localized", health="lost", motors_enabled=False),
    denied("stop_button", stop_button=True, motors_enabled=False),
    denied("stop_button", stop_button=True, charging=True),
    denied("charging", charging=True, motors_enabled=False),
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
    # nor before scans have shown the motion that the wheels count
    Case((0.3, 0.4), (0.15, 0.2), "unsure", {"unproven": True}),
    Case((0.0, 1.2), (0.0, 1.2), "none", {"unproven": True}),
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
    denied("body_unknown", limited=True, body_known=False),
    denied("overloaded", limited=True, overloaded=True),
    denied("stop_button", limited=True, stop_button=True),
    denied("charging", limited=True, charging=True),
    denied("motors_off", limited=True, motors_enabled=False),
    denied("stalled", limited=True, stalled=True),
    denied("bumper", limited=True, bumpers=2),
    denied("overspeed", limited=True, v=0.71),
    Case(DRIVE, ZERO, "backing", {"limited": True}, last_requested=(-0.01, 0.3)),
    Case(DRIVE, ZERO, "obstacle", {"limited": True, "obstacles": [(0.25, 0.1)]}),
    # getting faster
    Case(DRIVE, (0.0, 0.0), "acceleration", steps=0),
    Case(DRIVE, (0.025, 0.0), "acceleration", steps=1),
    Case(DRIVE, (0.075, 0.0), "acceleration", steps=2),
    Case((0.0, 1.2), (0.0, 0.2), "acceleration", steps=1),
    Case((0.0, -1.2), (0.0, -0.2), "acceleration", steps=1),
    Case(DRIVE, (0.15, 0.0), "acceleration", steps=1, last_time=9.0),
    Case(DRIVE, (0.0, 0.0), "acceleration", steps=1, last_time=END - 0.2),
    Case((0.0, 1.0), (0.0, 0.8), "acceleration", last_requested=(0.0, -1.2)),
    Case((0.7, 0.0), (0.025, 0.0), "speed_limit", steps=1),
    # turning follows the base both ways; driving slower is never delayed
    Case(DRIVE, (0.1, 0.0), last_requested=(0.1, 0.0)),
    Case(DRIVE, ZERO, last_requested=ZERO),
    Case((0.0, 1.2), (0.0, 1.0), "acceleration", last_requested=(0.0, 0.1)),
    Case((0.0, -1.2), (0.0, -1.0), "acceleration", last_requested=ZERO),
    Case((0.0, 1.2), (0.0, 1.1), last_requested=(0.0, 1.1)),
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
    # unless it edges out straight and slowly: nothing alongside comes nearer, also a little inside
    Case(EDGE, EDGE, "none", {"obstacles": [(0.0, 0.22), (-0.2, 0.1926), (-0.2, -0.1926)]}),
    Case(EDGE, ZERO, "obstacle", {"obstacles": [(-0.2, 0.1924)]}),
    Case(EDGE, ZERO, "obstacle", {"obstacles": [(0.211, 0.22)]}),
    Case(EDGE, ZERO, "obstacle", {"obstacles": [(0.21, 0.22)]}),
    Case(EDGE, EDGE, "none", {"obstacles": [(-0.2, 0.2125 - 0.02)]}),
    Case((0.1, 0.05), ZERO, "obstacle", {"obstacles": [(0.0, 0.22)]}),
    Case((0.108, 0.0), (0.108, 0.0), "none", {"obstacles": [(0.0, 0.22)], "v": 0.108}),
    Case((0.12, 0.0), ZERO, "obstacle", {"obstacles": [(0.0, 0.22)]}),
    # behind: from what is within the margin it edges away, also from a little inside
    Case(EDGE, EDGE, "none", {"obstacles": [(-0.31, 0.0), (-0.2811, -0.1), (0.02 - 0.301, 0.1)]}),
    Case(EDGE, ZERO, "obstacle", {"obstacles": [(-0.2809, 0.0)]}),
    Case((0.1, 0.05), ZERO, "obstacle", {"obstacles": [(-0.31, 0.0)]}),
    Case(DRIVE, DRIVE, "none", {"obstacles": [(-0.33, 0.0), (-2.0, 0.0)]}),
    Case(DRIVE, ZERO, "obstacle", {"obstacles": [(-0.29, 0.0)]}),
    # arcs are swept, not straight ahead
    Case((0.35, 0.7), (0.35, 0.7), "none", {"obstacles": [(0.55, -0.25)]}),
    Case((0.35, -0.7), (0.35, -0.7), "none", {"obstacles": [(0.55, 0.25)]}),
    # driving needs sight of the front edge at the end of the stopping way, turning does not
    Case(DRIVE, ZERO, "unseen", {"views": ()}),
    Case(DRIVE, ZERO, "unseen", {"views": (), "limited": True}),
    Case((0.35, 0.7), (0.0, 0.7), "unseen", {"views": ()}),
    Case((0.0, 1.2), (0.0, 1.2), "none", {"views": ()}),
    Case(DRIVE, DRIVE, "none", fan(0.0, CORNER + 0.001)),
    Case(DRIVE, ZERO, "unseen", fan(0.0, CORNER - 0.001)),
    Case(DRIVE, ZERO, "unseen", fan(0.1, CORNER + 0.001)),
    Case(DRIVE, ZERO, "unseen", fan(-0.1, CORNER + 0.001)),
    Case(DRIVE, DRIVE, "none", fan(0.0, 1.0, FAR_CORNER + 0.001)),
    Case(DRIVE, ZERO, "unseen", fan(0.0, 1.0, FAR_CORNER - 0.001)),
    Case(DRIVE, ZERO, "unseen", fan(math.pi, 1.5)),
    Case(DRIVE, DRIVE, "none", spots(*edge(S))),
    Case(DRIVE, ZERO, "unseen", spots(*edge(S)[:2])),
    Case(DRIVE, ZERO, "unseen", spots(*edge(S)[1:])),
    Case(DRIVE, ZERO, "unseen", spots(*edge(S)[::2])),
    Case((0.2, 0.0), (0.2, 0.0), "none", spots(*edge(stopping(0.4))) | {"v": 0.4}),
    Case((0.2, 0.0), (0.2, 0.0), "none", spots(*edge(stopping(0.2))) | {"v": 0.1}),
    Case((0.35, 0.7), (0.35, 0.7), "none", spots(*(met(12, 1, a) for a in SIDES))),
    Case((0.35, -0.7), (0.35, -0.7), "none", spots(*(met(12, -1, a) for a in SIDES))),
    Case(DRIVE, ZERO, "unseen", spots(*(met(12, 1, a) for a in SIDES))),
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
    Case((0.01, 0.2), (0.01, 0.2), "none", {"v": 0.3, "obstacles": []}),
    Case((0.01, 0.2), (0.01, 0.2), "none", {"v": 0.3, "obstacles": [(3.0, 0.0)]}),
    Case((0.1, 0.2), (0.1, 0.2), "none", {"v": 0.3, "obstacles": [(-0.33, 0.0)]}),
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


@dataclass(frozen=True)
class Step:
    """One call of the gate at t, with some inputs changed, and the expected result."""

    t: float
    reason: str
    inputs: dict[str, Any] = field(default_factory=dict)
    requested: tuple[float, float] = DRIVE
    v: float | None = None
    w: float | None = None
    between: bool = False
    """Between two reports: only ages are looked at; the reason may be that it GOES_ON."""


@dataclass(frozen=True)
class Story:
    """Calls of one gate, and how many stops of each kind it has counted after them."""

    steps: list[Step]
    stops: dict[str, int] = field(default_factory=dict)
    settings: dict[str, float] = field(default_factory=dict)


def holds(story: Story, module: ModuleType = gate) -> bool:
    """Return whether the gate of a module passes a sequence of calls."""
    tested = module.SafetyGate(module.GateLimits(**story.settings))
    for step in story.steps:
        given = inputs(module, step.t, **step.inputs)
        if step.between:
            decision = tested.expire(step.t, given.base_time, given.scan_time)
        else:
            decision = tested.permit(step.t, step.requested, given)
        if decision is None and step.reason == GOES_ON:
            continue
        if decision.reason != step.reason:
            return False
        for permitted_rate, rate in ((decision.v, step.v), (decision.w, step.w)):
            if rate is not None and not math.isclose(permitted_rate, rate, abs_tol=1e-6):
                return False
    return dict(tested.stops) == story.stops


BUMPED = {"bumpers": 4}
HIT = {"stalled": True}
BUTTON = {"stop_button": True}
GOES = "acceleration"  # from standstill
GOES_ON = "goes on"


def between(t: float, reason: str, **ages: float) -> Step:
    """Between two reports, with ages in s of base report and scan."""
    times = {f"{name}_time": t - age for name, age in ages.items()}
    return Step(t, reason, times, v=0.0, between=True)


def pressed(*times: float) -> list[Step]:
    """A bumper pressed at each time and free 0.1 s later."""
    return [step for t in times for step in (Step(t, "bumper", BUMPED, v=0.0), Step(t + 0.1, GOES))]


def stalled_at(*times: float) -> list[Step]:
    return [step for t in times for step in (Step(t, "stalled", HIT, v=0.0), Step(t + 0.1, GOES))]


def battery(t: float, volts: float, reason: str = "none") -> Step:
    return Step(t, reason, {"battery": volts}, requested=ZERO)


FLANK = 0.2125  # m, half the width
FIRST = 0.2  # rad/s, permitted in the first step of a turn
TURN_PER_POSE = stopping(FIRST, 2.0) / 12


def nearing(side: int, clearance: float) -> tuple[float, float]:
    """Position of a point beside the rear of a flank, which a turn to a side, +1 left, nears."""
    return -0.25, -side * (FLANK + clearance)


def clearance_for(margin: float, poses_free: int) -> float:
    """Clearance of such a point that comes within a margin after so many poses of a first turn."""
    angle = TURN_PER_POSE * (poses_free + 0.5)
    return (FLANK + margin + 0.25 * math.sin(angle)) / math.cos(angle) - FLANK


def turn(
    t: float,
    side: int,
    w: float,
    reason: str = "obstacle",
    *points: tuple[float, float],
    base_w: float = 0.0,
) -> Step:
    """A step of a turn in place at t to a side, +1 left, with obstacles.

    w: permitted, base_w: of the base, both rad/s to that side.
    """
    seen = {"obstacles": points} if points else {}
    return Step(t, reason, {"w": side * base_w, **seen}, (0.0, side * 1.2), v=0.0, w=side * w)


def stopped(side: int) -> list[Step]:
    """A turn to a side that an obstacle stops at 0.2 s, nearer than the turn margin."""
    return [
        turn(0.0, side, 0.0, GOES),
        turn(0.1, side, FIRST, GOES),
        turn(0.2, side, 0.0, "obstacle", nearing(side, 0.019), base_w=0.6),
    ]


def hardly_begun(side: int) -> list[list[Step]]:
    """Steps up to 1 s, the last of which stops a turn to a side that has not gone 0.05 rad."""
    stop = nearing(side, 0.019)
    first = turn(0.0, side, 0.0, GOES)
    last = turn(1.0, side, 0.0, "obstacle", stop)
    return [
        [turning(0.9, 0.0), turn(1.0, side, 0.0, "obstacle", stop, base_w=0.45)],
        [first, turning(0.25, side * 0.2), last],  # 0.05 rad to the bit
        [turning(0.4, 0.0), turning(0.5, side * 1.0), turning(0.6, -side * 0.2), last],
        [
            turning(0.4, 0.0),
            turning(0.5, side * 0.4),
            turning(0.6, -side * 0.1),
            turning(0.7, side * 0.4),
            last,
        ],
        [turning(0.4, 0.0), turning(0.5, side * 1.0), Step(0.6, GOES, v=0.025), last],
    ]


def well_begun(side: int) -> list[list[Step]]:
    """Likewise of a turn that has, also in parts."""
    last = turn(1.0, side, 0.0, "obstacle", nearing(side, 0.019))
    return [
        [turning(0.4, 0.0), turning(0.5, side * 0.55), last],
        [turning(0.4, 0.0), turning(0.5, side * 0.3), turning(0.6, side * 0.3), last],
        [
            turning(0.4, 0.0),
            turning(0.5, side * 0.3),
            turning(0.6, 0.0),
            turning(0.7, side * 0.3),
            last,
        ],
        [turning(0.4, 0.0), turning(0.5, -side * 1.0), turning(0.6, side * 0.55), last],
    ]


def turning(t: float, w: float) -> Step:
    """A step at t in which the base still turns with w, rad/s, and nothing is requested."""
    return Step(t, "none", {"w": w}, requested=ZERO, v=0.0, w=0.0)


def turned_on(side: int) -> list[Story]:
    """A turn that an obstacle stopped needs more room to that side, until driving or away."""
    there, back, other = 0.21 + 0.025, -0.30 - 0.025, -side
    near, room = nearing(side, 0.025), nearing(side, clearance_for(0.035, 5))
    slowly, on = turned(FIRST, 3), turned(FIRST, 5)
    once, begun = {"obstacle": 1}, stopped(side)
    braked = (FRONT + stopping(0.025) * 11.5 / 12, 0.0)
    return [
        # what is nearer than that comes no nearer, on any face of the body
        Story([*begun, turn(0.3, side, 0.0, "obstacle", near)], once),
        Story([*begun, turn(0.3, side, 0.0, "obstacle", (there, -side * 0.1))], once),
        Story([*begun, turn(0.3, side, 0.0, "obstacle", (back, side * 0.1))], once),
        # but a turn away from it is free
        Story([*begun, turn(0.3, side, FIRST, GOES, nearing(other, 0.025))], once),
        Story([*begun, turn(0.3, side, FIRST, GOES, (there, side * 0.1))], once),
        Story([*begun, turn(0.3, side, FIRST, GOES, (back, -side * 0.1))], once),
        # unless it is nearer than any turn may come
        Story([*begun, turn(0.3, side, 0.0, "obstacle", nearing(other, 0.0185))], once),
        # without a turn it stays so
        Story(
            [
                *begun,
                Step(0.3, "none", requested=ZERO, v=0.0, w=0.0),
                turn(0.4, side, 0.0, "obstacle", near),
            ],
            {"obstacle": 2},
        ),
        # with more room it goes on, and then as before
        Story(
            [
                *begun,
                turn(0.3, side, on, "obstacle", room),
                turn(0.4, side, turned(on + FIRST, 2), "obstacle", near),
            ],
            once,
        ),
        # a turn to the other side was not stopped, nor one that had not begun
        Story([*begun, turn(0.3, other, slowly, "obstacle", nearing(other, 0.025))], once),
        Story(
            [
                turn(0.0, side, 0.0, GOES),
                turn(0.1, side, 0.0, "obstacle", nearing(side, 0.019)),
                turn(0.2, side, slowly, "obstacle", near),
            ],
            once,
        ),
        Story(
            [
                *begun[:2],
                turn(0.2, other, 0.0, GOES, nearing(other, 0.019)),
                turn(0.3, other, slowly, "obstacle", nearing(other, 0.025)),
            ]
        ),
        # a turn stopped within 0.05 rad had hardly begun, since the robot drove or turned otherwise
        *(
            Story([*before, turn(1.1, side, slowly, "obstacle", near)], once)
            for before in hardly_begun(side)
        ),
        *(
            Story([*before, turn(1.1, side, 0.0, "obstacle", near)], once)
            for before in well_begun(side)
        ),
        # 0.2 rad away from there ends it, wherever the turn away began
        Story(
            [
                *begun,
                turning(0.3, -side * 1.05),
                turning(0.4, -side * 1.05),
                turn(0.5, side, slowly, "obstacle", near),
            ],
            once,
        ),
        Story(
            [
                *begun,
                turning(0.3, side * 1.5),
                turning(0.4, -side * 1.05),
                turning(0.5, -side * 1.05),
                turn(0.6, side, slowly, "obstacle", near),
            ],
            once,
        ),
        Story(
            [
                *begun,
                turning(0.3, -side * 0.95),
                turning(0.4, -side * 0.95),
                turn(0.5, side, 0.0, "obstacle", near),
            ],
            {"obstacle": 2},
        ),
        Story(
            [
                *begun,
                turning(0.3, -side * 1.05),
                turning(0.4, side * 0.3),
                turning(0.5, -side * 1.05),
                turn(0.6, side, 0.0, "obstacle", near),
            ],
            {"obstacle": 2},
        ),
        Story(  # 0.2 rad to the bit
            [
                *begun,
                turning(0.45, -side * 0.8),
                turn(0.55, side, 0.0, "obstacle", near),
            ],
            {"obstacle": 2},
        ),
        # stopped there again, the way away counts from its beginning
        Story(
            [
                *begun,
                turning(0.3, -side * 1.05),
                turning(0.4, -side * 1.05),
                turn(0.5, side, FIRST, GOES),
                turn(0.6, side, 0.0, "obstacle", nearing(side, 0.019), base_w=0.6),
                turning(0.7, -side * 1.05),
                turn(0.8, side, 0.0, "obstacle", near),
            ],
            {"obstacle": 3},
        ),
        # what stopped it may be a part of the robot, before scans have shown any motion
        Story(
            [
                *begun[:2],
                Step(
                    0.2,
                    "obstacle",
                    {"obstacles": [nearing(side, 0.019)], "unproven": True, "w": side * 0.6},
                    requested=(0.0, side * 1.2),
                    v=0.0,
                    w=0.0,
                ),
                turn(0.3, side, slowly, "obstacle", near),
            ],
            once,
        ),
        # driving ends it, also if an obstacle slows it
        Story([*begun, Step(0.3, GOES, v=0.025), turn(0.4, side, slowly, "obstacle", near)], once),
        Story(
            [
                *begun,
                Step(0.3, "obstacle", {"obstacles": [braked]}, v=ahead(0.025, 11)),
                turn(0.4, side, slowly, "obstacle", near),
            ],
            once,
        ),
    ]


def turned_back(side: int) -> list[Story]:
    """Back to where the body has been a turn may leave what is within its margin."""
    once = {"obstacle": 1}
    begun = [turning(0.0, 0.0), turning(0.1, side * 0.8)]  # 0.08 rad; a first turn needs 0.06
    near = nearing(side, 0.010)
    return [
        Story([*begun, turn(0.2, -side, FIRST, GOES, near)]),
        # but not come nearer, nor leave what is far inside
        Story([*begun, turn(0.2, -side, 0.0, "obstacle", nearing(-side, 0.010))], once),
        Story([*begun, turn(0.2, -side, FIRST, GOES, nearing(side, -0.0205))]),
        Story([*begun, turn(0.2, -side, 0.0, "obstacle", nearing(side, -0.022))], once),
        # not farther than it has been
        Story([turning(0.0, 0.0), turn(0.1, -side, 0.0, "obstacle", near)], once),
        Story(
            [
                turning(0.0, 0.0),
                turning(0.1, side * 0.5),
                turn(0.2, -side, 0.0, "obstacle", near),
            ],
            once,
        ),
        Story(
            [
                turning(0.0, 0.0),
                turning(0.25, side * stopping(0.25, 2.0) / 0.25),  # so far to the bit
                turn(0.375, -side, 0.25, GOES, near),
            ]
        ),
        Story([*begun, turning(0.2, -side * 0.4), turn(0.3, -side, 0.0, "obstacle", near)], once),
        Story(
            [
                *begun,
                turning(0.2, -side * 1.6),
                turning(0.3, side * 0.8),
                turn(0.4, -side, FIRST, GOES, near),
            ]
        ),
        # nor once it has driven, or may have been moved
        Story([*begun, Step(0.2, GOES, v=0.025), turn(0.3, -side, 0.0, "obstacle", near)], once),
        Story(
            [
                *begun,
                Step(0.2, "bumper", BUMPED, v=0.0),
                turn(0.3, -side, 0.0, GOES),
                turn(0.4, -side, 0.0, "obstacle", near),
            ],
            {"bumper": 1, "obstacle": 1},
        ),
    ]


STORIES = [
    # between two reports what was let pass is withdrawn once, when a report or a scan is too old
    Story(
        [
            between(0.0, GOES_ON, base=9.0, scan=9.0),  # nothing moves yet
            Step(0.1, GOES, v=0.0),
            between(0.15, GOES_ON, base=9.0, scan=9.0),
            Step(0.2, GOES, v=0.025),
            between(0.25, GOES_ON, base=0.279, scan=0.339),
            Step(0.26, GOES),
            between(0.3, "stale_base", base=0.281, scan=9.0),
            between(0.35, GOES_ON, base=9.0, scan=9.0),  # is withdrawn
            Step(0.4, GOES, v=0.0),
            Step(0.5, GOES, v=0.025),
            between(0.55, "stale_laser", base=0.1, scan=0.341),
            Step(0.6, GOES, v=0.0),
        ],
        {"stale_base": 1, "stale_laser": 1},
    ),
    Story(
        [
            Step(0.0, GOES, requested=(0.0, 1.2)),
            Step(0.1, GOES, requested=(0.0, 1.2)),
            between(0.15, "stale_laser", scan=0.5),  # a turn is withdrawn too
        ],
        {"stale_laser": 1},
    ),
    Story(
        [
            Step(0.0, GOES),
            Step(0.1, GOES),
            Step(0.15, "stale_base", {"base_time": None}, v=0.0, between=True),
        ],
        {"stale_base": 1},
    ),
    Story(
        [
            Step(0.0, GOES),
            Step(0.1, GOES),
            Step(0.15, "stale_laser", {"scan_time": None}, v=0.0, between=True),
        ],
        {"stale_laser": 1},
    ),
    Story(
        [Step(0.0, GOES), Step(0.1, GOES), between(0.15, GOES_ON, base=0.4, scan=0.4)],
        settings={"max_base_age": 0.5, "max_scan_age": 0.5},
    ),
    # jerk: acceleration grows by 0.25 m/s2 per step of 0.1 s, up to 0.5 m/s2
    Story([Step(0.1 * k, GOES, v=v) for k, v in enumerate((0.0, 0.025, 0.075, 0.125, 0.175))]),
    # slower for a moment: acceleration grows from nothing again
    Story(
        [
            *(Step(0.1 * k, GOES, v=v) for k, v in enumerate((0.0, 0.025, 0.075, 0.125))),
            Step(0.4, "none", requested=(0.1, 0.0), v=0.1),
            Step(0.5, GOES, v=0.125),
            Step(0.6, GOES, v=0.175),
        ]
    ),
    # a gain cut short by the request counts as it was
    Story(
        [
            Step(0.0, GOES, v=0.0),
            Step(0.1, GOES, v=0.025),
            Step(0.2, "none", requested=(0.035, 0.0), v=0.035),
            Step(0.3, GOES, v=0.07),
        ]
    ),
    # a denial: standstill, and no acceleration
    Story(
        [
            *(Step(0.1 * k, GOES, v=v) for k, v in enumerate((0.0, 0.025, 0.075))),
            Step(0.3, "stale_laser", {"scan_time": None}, v=0.0),
            Step(0.4, GOES, v=0.0),
            Step(0.5, GOES, v=0.025),
        ],
        {"stale_laser": 1},
    ),
    # the same time twice is no time
    Story([Step(0.0, GOES, v=0.0), Step(0.0, GOES, v=0.0), Step(0.1, GOES, v=0.025)]),
    # a bumper pressed twice is latched, also when it is free again
    Story(
        [
            *pressed(0.0),
            Step(1.0, "bumped_again", BUMPED, v=0.0),
            Step(1.1, "bumped_again", v=0.0),
            Step(500.0, "bumped_again", v=0.0),
            # before all that a person may have done to the motors
            Step(500.1, "bumped_again", {"motors_enabled": False}, v=0.0),
            Step(500.2, "bumped_again", v=0.0),
            # the stop button releases it, once it is free
            Step(500.3, "bumped_again", BUTTON, v=0.0),
            Step(500.4, GOES, v=0.0),
            # and everything is forgotten
            *pressed(501.0),
            Step(501.2, "bumped_again", BUMPED),
        ],
        {"bumper": 2, "bumped_again": 2},
    ),
    Story([*pressed(0.0), Step(59.9, "bumped_again", BUMPED)], {"bumper": 1, "bumped_again": 1}),
    Story([*pressed(0.0, 60.0)], {"bumper": 2}),
    Story(
        [*pressed(0.0, 61.0), Step(70.0, "bumped_again", BUMPED)], {"bumper": 2, "bumped_again": 1}
    ),
    Story(pressed(0.0, 1.0), {"bumper": 2}, settings={"bumps": 3}),
    # held is pressed once
    Story(
        [Step(0.0, "bumper", BUMPED), Step(0.1, "bumper", BUMPED), Step(0.2, GOES)], {"bumper": 1}
    ),
    # pressed while the stop button holds: a person is at the robot
    Story(
        [
            *pressed(0.0),
            Step(1.0, "stop_button", BUTTON | BUMPED),
            Step(1.1, "stop_button", BUTTON),
            Step(1.2, "stop_button", BUTTON | BUMPED),
            Step(1.3, GOES),
        ],
        {"bumper": 1, "stop_button": 1},
    ),
    # three stalls
    Story(stalled_at(0.0, 1.0), {"stalled": 2}),
    Story(
        [
            *stalled_at(0.0, 1.0),
            Step(2.0, "stalled_again", HIT, v=0.0),
            Step(2.1, "stalled_again", v=0.0),
            Step(2.2, "stalled_again", BUTTON, v=0.0),
            Step(2.3, GOES, v=0.0),
            *stalled_at(3.0, 4.0),
        ],
        {"stalled": 4, "stalled_again": 1},
    ),
    Story(stalled_at(0.0, 1.0, 60.0), {"stalled": 3}),
    # a low battery, for a while
    Story([battery(0.0, 11.0), battery(2.0, 11.0), battery(4.0, 11.0)]),
    Story(
        [
            battery(0.0, 10.9),
            battery(1.9, 10.9),
            battery(2.0, 10.9, "battery_low"),
            battery(2.1, 11.9, "battery_low"),
            battery(2.2, 12.0),
            battery(2.3, 11.5),
            battery(2.4, 10.9),
            battery(4.3, 10.9),
            battery(4.4, 10.9, "battery_low"),
        ],
        {"battery_low": 2},
    ),
    Story([battery(0.0, 10.9), battery(1.9, 11.0), battery(2.0, 10.9), battery(3.9, 10.9)]),
    Story(
        [battery(0.0, 10.9), battery(0.1, 10.9, "battery_low")],
        {"battery_low": 1},
        settings={"battery_patience": 0.1},
    ),
    Story(
        [battery(0.0, 11.4), battery(9.0, 11.4, "battery_low")],
        {"battery_low": 1},
        settings={"battery_cutoff": 11.5},
    ),
    Story(
        [battery(0.0, 11.0)],
        settings={"battery_cutoff": 11.0, "battery_resume": 11.0},
    ),
    # stops are counted when they begin; limits are none, an obstacle is one if nothing passes
    Story(
        [
            Step(0.0, "stale_base", {"base_time": None}),
            Step(0.1, "stale_base", {"base_time": None}),
            Step(0.2, "not_localized", {"health": "lost"}),
            Step(0.3, "stale_base", {"base_time": None}),
            Step(0.4, GOES),
            Step(0.5, "obstacle", {"obstacles": [(0.25, 0.1)]}),
            Step(0.6, "obstacle", {"obstacles": [(0.25, 0.1)]}),
            Step(0.7, "limited", {"limited": True}, requested=(0.3, 0.0)),
            Step(0.8, "unsure", {"health": "unsure"}, requested=(0.3, 0.0)),
        ],
        {"stale_base": 2, "not_localized": 1, "obstacle": 1},
    ),
    Story(
        [
            Step(0.0, "acceleration", requested=(0.2, 0.8)),
            Step(0.1, "obstacle", {"obstacles": [(0.27, 0.0)]}, requested=(0.2, 0.8), v=0.0),
            Step(0.2, "obstacle", {"obstacles": [(0.27, 0.0)]}, requested=(0.2, 0.0), v=0.0),
        ],
    ),
    Story(
        [
            *(Step(0.1 * k, GOES) for k in range(7)),
            Step(0.7, "obstacle", {"obstacles": [(0.4101 + S / 2, 0.0)]}),
        ],
    ),
    *turned_on(1),
    *turned_on(-1),
    *turned_back(1),
    *turned_back(-1),
]


def all_hold(module: ModuleType) -> bool:
    """Return whether the gate of a module passes every case and sequence."""
    return all(fits(case, run(case, module)) for case in CASES) and all(
        holds(story, module) for story in STORIES
    )
