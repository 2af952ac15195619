"""Why the safety gate cuts a command."""

from __future__ import annotations

from enum import StrEnum


class GateReason(StrEnum):
    """Why a command was cut; NONE if it was not."""

    NONE = "none"
    INVALID = "invalid"  # an input is NaN or infinite
    STALE_BASE = "stale_base"
    STALE_LASER = "stale_laser"
    BODY_UNKNOWN = "body_unknown"  # no model known to be this robot's: its size is a guess
    OVERLOADED = "overloaded"  # the agent misses its deadlines
    LASER_MOUNT = "laser_mount"  # the laser sees other motion than the wheels, or the robot
    NOT_LOCALIZED = "not_localized"
    BUMPED_AGAIN = "bumped_again"  # latched until a person has inspected the robot
    STALLED_AGAIN = "stalled_again"  # latched likewise
    STOP_BUTTON = "stop_button"
    CHARGING = "charging"  # or the base reports an unknown state of its charger
    BATTERY_LOW = "battery_low"
    MOTORS_OFF = "motors_off"
    STALLED = "stalled"
    BUMPER = "bumper"
    OVERSPEED = "overspeed"  # the base moves faster than any command permits
    BACKING = "backing"
    OBSTACLE = "obstacle"
    UNSEEN = "unseen"  # no sensor covers the way; the robot may still turn in place
    LIMITED = "limited"  # slow, as the limited mode needs no pose
    UNSURE = "unsure"
    SPEED_LIMIT = "speed_limit"
    ACCELERATION = "acceleration"


LIMITS = frozenset(
    {
        GateReason.NONE,
        GateReason.OBSTACLE,
        GateReason.UNSEEN,
        GateReason.LIMITED,
        GateReason.UNSURE,
        GateReason.SPEED_LIMIT,
        GateReason.ACCELERATION,
    }
)
"""Reasons under which a robot may still move."""
STANDING = frozenset({GateReason.OBSTACLE, GateReason.UNSEEN})
"""Limits under which the robot may have to stand."""
DENIALS = frozenset(GateReason) - LIMITS
"""Reasons under which no motion is permitted."""
LATCHED = frozenset({GateReason.BUMPED_AGAIN, GateReason.STALLED_AGAIN})
"""Denials that only a person at the robot clears, by its MOTORS button (or a restart)."""
