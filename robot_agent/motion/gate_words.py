"""Reasons of the gate in words for people: the same in events, on the page and in reports."""

from __future__ import annotations

from robot_agent.motion.gate_reason import GateReason

GATE_WORDS: dict[str, str] = {
    GateReason.INVALID: "a number that is not finite",
    GateReason.STALE_BASE: "no fresh report of the base",
    GateReason.STALE_LASER: "no fresh laser scan",
    GateReason.BODY_UNKNOWN: "no model is known to be this robot's",
    GateReason.OVERLOADED: "the computer is overloaded",
    GateReason.LASER_MOUNT: "the laser is not as configured: laser.mount, laser.ignore",
    GateReason.NOT_LOCALIZED: "not localized",
    GateReason.BUMPED_AGAIN: "bumped again and again, a person must look",
    GateReason.STALLED_AGAIN: "stalled again and again, a person must look",
    GateReason.STOP_BUTTON: "the stop button is pressed",
    GateReason.CHARGING: "on its charger: unplug it",
    GateReason.BATTERY_LOW: "the battery is low",
    GateReason.MOTORS_OFF: "motors are off",
    GateReason.STALLED: "a motor is stalled",
    GateReason.BUMPER: "a bumper is pressed",
    GateReason.OVERSPEED: "the base is faster than commanded",
    GateReason.BACKING: "backwards is not allowed",
    GateReason.OBSTACLE: "obstacle ahead",
    GateReason.UNSEEN: "no sensor looks where it would drive",
    GateReason.LIMITED: "slow, driving without a pose",
    GateReason.UNSURE: "pose uncertain",
    GateReason.SPEED_LIMIT: "speed limit",
    GateReason.ACCELERATION: "acceleration limit",
}
