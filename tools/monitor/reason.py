"""What a robot does and why, in one sentence: the same text for the page and the terminal."""

from __future__ import annotations

import math

from robot_agent.messages.streams import DecisionPayload
from robot_agent.motion.gate_reason import DENIALS, STANDING
from robot_agent.motion.gate_words import GATE_WORDS
from robot_agent.motion.obstacle_points import ObstacleSource
from robot_agent.patrol.modifier import OverrideReason
from robot_agent.report.notices import TURN_WORDS
from tools.monitor.robot_state import RobotState

STALE_S = 1.5
"""Age from which a decision is stale."""
_STANDSTILL = 0.02  # m/s, rad/s

SOURCE_WORDS: dict[str, str] = {
    ObstacleSource.LASER: "seen by the laser",
    ObstacleSource.REMEMBERED: "seen by the laser before",
    ObstacleSource.SONAR: "seen by a sonar",
    ObstacleSource.MAP_WALL: "a wall of the map",
    ObstacleSource.TEAMMATE_ROOM: "room for a teammate to turn",
    ObstacleSource.PERSON_ROOM: "room for a person's trunk and feet",
}
OVERRIDE_WORDS: dict[str, str] = {
    OverrideReason.STANDOFF: "takes its way after a long standoff",
    OverrideReason.HOLD_AT_END: "waits, caught between a teammate and an end of the border",
    OverrideReason.BLOCKAGE: "turns, waited too long for an object on its way",
    OverrideReason.WAIT: "waits briefly, not to turn in step with others",
    OverrideReason.CLOSING_IN: "comes slowly closer than usual",
    OverrideReason.EVEN_GAPS: "for even gaps",
    OverrideReason.COMMON_TURNS: "in step with the team",
}
HOLDING_REASONS = DENIALS | STANDING
"""Reasons of the gate that can stop a robot, not merely slow it."""


def held_by_gate(decision: DecisionPayload) -> bool:
    """Return whether the gate stops a requested motion completely."""
    asked = abs(decision.requested.v) > _STANDSTILL or abs(decision.requested.w) > _STANDSTILL
    moves = abs(decision.command.v) > _STANDSTILL or abs(decision.command.w) > _STANDSTILL
    return decision.gate_reason in HOLDING_REASONS and asked and not moves


def why(robot: RobotState, now: float) -> str:
    """Return what a robot does and why, at the operator's monotonic time now, s."""
    decision, status = robot.decision, robot.status
    age = robot.age("decision", now)
    if decision is None or age is None or age > STALE_S:
        if robot.last_heard is None or now - robot.last_heard > STALE_S:
            return "nothing received"
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
    words = GATE_WORDS.get(reason, reason)
    held = decision.held_by
    if held is None:
        return words
    away = math.dist((held.x, held.y), (decision.pose.x, decision.pose.y))
    return f"{words}, {SOURCE_WORDS.get(held.source, held.source)}, {away:.1f} m from its middle"


def _action_words(decision: DecisionPayload) -> str:
    """Return the action in force, or the override in place of it, with its input."""
    if decision.holding:
        return OVERRIDE_WORDS.get(decision.override or "", "waits, caught between teammates")
    words = _chosen_words(decision)
    special = OVERRIDE_WORDS.get(decision.override or "")
    return words if special is None else f"{words}: {special}"


def turn_words(robot: RobotState, now: float) -> str:
    """Return why and how long ago the robot last turned back; empty if no turn was received."""
    if robot.last_turn is None:
        return ""
    t, cause = robot.last_turn
    return f"{TURN_WORDS.get(cause, cause)}, {max(now - t, 0.0):.0f} s ago"


def _chosen_words(decision: DecisionPayload) -> str:
    """Return the action in force with the input that selected it."""
    sense = "clockwise" if decision.direction > 0 else "counter-clockwise"
    near = decision.distance_from_neighbor
    teammate = "no teammate near" if near is None else f"teammate {near:.1f} m away"
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
