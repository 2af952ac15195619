"""What a robot does and why, in one sentence: the same words for the page and the terminal."""

from __future__ import annotations

from robot_agent.streams import DecisionPayload
from tools.monitor.robot_state import RobotState

STALE_S = 1.5
"""Decisions older than this say nothing of the present."""
_STANDING = 0.02  # m/s, rad/s

GATE_WORDS = {
    "invalid": "a number that is none",
    "stale_base": "no fresh report of the base",
    "stale_laser": "no fresh laser scan",
    "not_localized": "not localized",
    "motors_off": "motors are off",
    "stalled": "a motor is stalled",
    "bumper": "a bumper is pressed",
    "overspeed": "the base is faster than it was told",
    "backing": "backwards is not allowed",
    "obstacle": "obstacle ahead",
    "unsure": "unsure of its pose",
    "speed_limit": "speed limit",
    "acceleration": "acceleration limit",
}
HOLDING_REASONS = frozenset(
    {
        "invalid",
        "stale_base",
        "stale_laser",
        "not_localized",
        "motors_off",
        "stalled",
        "bumper",
        "overspeed",
        "obstacle",
    }
)
"""Reasons of the gate that can hold a robot, not merely slow it."""


def held_by_gate(decision: DecisionPayload) -> bool:
    """Tell whether the gate keeps a robot that wishes to move from moving at all."""
    wished = abs(decision.wish.v) > _STANDING or abs(decision.wish.w) > _STANDING
    moves = abs(decision.command.v) > _STANDING or abs(decision.command.w) > _STANDING
    return decision.gate_reason in HOLDING_REASONS and wished and not moves


def why(robot: RobotState, now: float) -> str:
    """Return what a robot does and why, at the operator's time now (s, monotonic)."""
    decision, status = robot.decision, robot.status
    age = robot.age("decision", now)
    if decision is None or age is None or age > STALE_S:
        if robot.last_heard is None or now - robot.last_heard > STALE_S:
            return "nothing heard of it"
        if status is None:
            return "no decision yet"
        return f"takes no decisions: {status.health}"
    if held_by_gate(decision):
        return f"held by the gate: {_gate_words(decision)}"
    words = _action_words(decision)
    if decision.gate_reason in HOLDING_REASONS or decision.gate_reason == "unsure":
        return f"{words}; slowed by the gate: {_gate_words(decision)}"
    return words


def _gate_words(decision: DecisionPayload) -> str:
    reason = decision.gate_reason or ""
    return GATE_WORDS.get(reason, reason)


def _action_words(decision: DecisionPayload) -> str:
    """Return the action with the input that speaks for it."""
    if decision.blocked:
        return "gave up waiting for an object on its way, turns back"
    if decision.holding:
        return "waits between an end of the border and a teammate"
    sense = "clockwise" if decision.direction > 0 else "counter-clockwise"
    near = decision.distance_from_neighbor
    teammate = "nobody near" if near is None else f"teammate {near:.1f} m away"
    match decision.action:
        case "reach_frontier":
            straight = decision.distance_from_border
            way = straight if decision.way_to_border is None else decision.way_to_border
            return f"drives to the border, {way:.1f} m to go"
        case "keep_going":
            return f"keeps going {sense}, {teammate}"
        case "patrol_clockwise" | "patrol_counter_clockwise":
            return f"patrols {sense}, {teammate}"
        case "avoid_teammate":
            return f"gives way, {teammate}"
        case action:
            return action
