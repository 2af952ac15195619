"""What the gate's last word means for a robot that wants to drive: limits, held, or pinned."""

from __future__ import annotations

from robot_agent.motion.gate import GateDecision
from robot_agent.motion.gate_reason import DENIALS, GateReason

_CRAWL = 0.05  # m/s; slower than this before an obstacle is as good as held by it
_CREEPING_TURN = 0.03  # rad/s; likewise of a turn

STOPPING = DENIALS - {GateReason.MOTORS_OFF, GateReason.BACKING} | {GateReason.OBSTACLE}
"""Reasons of the gate that mean the robot is being held, not merely kept to its limits."""


def begins_hold(before: GateDecision | None, gate: GateDecision) -> bool:
    """Tell whether the gate holds a robot that it did not hold before."""
    return gate.reason in STOPPING and (before is None or before.reason not in STOPPING)


def held_by_obstacle(gate: GateDecision | None) -> bool:
    """Tell whether the gate's last word was to stand still before an obstacle, or about to."""
    return gate is not None and gate.reason is GateReason.OBSTACLE and gate.v < _CRAWL


def pinned_by_obstacle(gate: GateDecision | None) -> bool:
    """Tell whether an obstacle lets the robot neither drive nor turn the way it wishes."""
    return gate is not None and held_by_obstacle(gate) and abs(gate.w) < _CREEPING_TURN
