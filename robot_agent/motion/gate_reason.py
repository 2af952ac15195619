"""Why the safety gate cuts a command."""

from __future__ import annotations

from enum import StrEnum


class GateReason(StrEnum):
    """Why a command was cut; NONE if it was not."""

    NONE = "none"
    INVALID = "invalid"  # a number that is none
    STALE_BASE = "stale_base"
    STALE_LASER = "stale_laser"
    OVERLOADED = "overloaded"  # the agent lags behind what it is told
    NOT_LOCALIZED = "not_localized"
    BUMPED_AGAIN = "bumped_again"  # latched until a person has looked
    STALLED_AGAIN = "stalled_again"  # latched likewise
    STOP_BUTTON = "stop_button"
    BATTERY_LOW = "battery_low"
    MOTORS_OFF = "motors_off"
    STALLED = "stalled"
    BUMPER = "bumper"
    OVERSPEED = "overspeed"  # the base moves faster than it can have been told to
    BACKING = "backing"
    OBSTACLE = "obstacle"
    LIMITED = "limited"  # slow, as nobody asked where the robot is
    UNSURE = "unsure"
    SPEED_LIMIT = "speed_limit"
    ACCELERATION = "acceleration"


LIMITS = frozenset(
    {
        GateReason.NONE,
        GateReason.OBSTACLE,
        GateReason.LIMITED,
        GateReason.UNSURE,
        GateReason.SPEED_LIMIT,
        GateReason.ACCELERATION,
    }
)
"""Reasons under which a robot may still move."""
DENIALS = frozenset(GateReason) - LIMITS
"""Reasons under which nothing moves."""
LATCHED = frozenset({GateReason.BUMPED_AGAIN, GateReason.STALLED_AGAIN})
"""Denials that only a person at the robot ends, by its MOTORS button (or a new start)."""
