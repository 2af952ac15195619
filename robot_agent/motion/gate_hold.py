"""Classification of a gate decision: robot merely limited, held, or pinned by an obstacle."""

from __future__ import annotations

from robot_agent.motion.gate import GateDecision
from robot_agent.motion.gate_reason import DENIALS, STANDING, GateReason

CRAWL = 0.05  # m/s; a robot permitted less before an obstacle counts as held by it
CREEPING_TURN = 0.03  # rad/s; likewise for a turn

STOPPING = DENIALS - {GateReason.MOTORS_OFF, GateReason.BACKING} | STANDING
"""Reasons by which the robot is held, not merely limited."""


def begins_hold(before: GateDecision | None, gate: GateDecision) -> bool:
    """Return whether the gate holds the robot now and did not by the decision before."""
    return gate.reason in STOPPING and (before is None or before.reason not in STOPPING)


def held_by_obstacle(gate: GateDecision | None) -> bool:
    """Return whether the decision stops the robot, or nearly, before an obstacle; None: no."""
    return gate is not None and gate.reason is GateReason.OBSTACLE and gate.v < CRAWL


def pinned_by_obstacle(gate: GateDecision | None) -> bool:
    """Return whether an obstacle permits the robot neither to drive nor to turn as requested."""
    return gate is not None and held_by_obstacle(gate) and abs(gate.w) < CREEPING_TURN
