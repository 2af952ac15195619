"""What a robot does and why, in one sentence: the same words for the page and the terminal."""

from __future__ import annotations

from robot_agent.messages.streams import DecisionPayload
from robot_agent.motion.gate_reason import DENIALS, GateReason
from tools.monitor.robot_state import RobotState

STALE_S = 1.5
"""Decisions older than this say nothing of the present."""
_STANDING = 0.02  # m/s, rad/s

GATE_WORDS: dict[str, str] = {
    GateReason.INVALID: "a number that is none",
    GateReason.STALE_BASE: "no fresh report of the base",
    GateReason.STALE_LASER: "no fresh laser scan",
    GateReason.OVERLOADED: "the computer is overloaded",
    GateReason.NOT_LOCALIZED: "not localized",
    GateReason.BUMPED_AGAIN: "bumped again and again, a person must look",
    GateReason.STALLED_AGAIN: "stalled again and again, a person must look",
    GateReason.STOP_BUTTON: "the stop button is pressed",
    GateReason.BATTERY_LOW: "the battery is low",
    GateReason.MOTORS_OFF: "motors are off",
    GateReason.STALLED: "a motor is stalled",
    GateReason.BUMPER: "a bumper is pressed",
    GateReason.OVERSPEED: "the base is faster than it was told",
    GateReason.BACKING: "backwards is not allowed",
    GateReason.OBSTACLE: "obstacle ahead",
    GateReason.LIMITED: "slow, its pose does not matter now",
    GateReason.UNSURE: "unsure of its pose",
    GateReason.SPEED_LIMIT: "speed limit",
    GateReason.ACCELERATION: "acceleration limit",
}
HOLDING_REASONS = frozenset({*DENIALS, GateReason.OBSTACLE})
"""Reasons of the gate that can hold a robot, not merely slow it."""


def held_by_gate(decision: DecisionPayload) -> bool:
    """Tell whether the gate keeps a robot that wishes to move from moving at all."""
    wished = abs(decision.requested.v) > _STANDING or abs(decision.requested.w) > _STANDING
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
        return "waits, caught between teammates, or one and an end of the border"
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
