"""Teleoperation by the keys of the robot's own terminal, for mapping: no map, pose or patrol.

A key is valid for HOLD_S: a released key, a lost terminal or a frozen process stops the robot.
Requests pass the gate's limited mode.
"""

from __future__ import annotations

from typing import Annotated

import msgspec

from robot_agent.messages.events import OperatorKey

_SPEED = 0.15  # m/s
_TURN_RATE = 0.4  # rad/s
HOLD_S = 0.7
"""s for which a key is valid: longer than the delay before keyboards repeat it."""


class TeleopSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of teleoperation."""

    enabled: Annotated[
        bool,
        msgspec.Meta(
            description="Set by `patrol record`: an agent that obeys keys does nothing else."
        ),
    ] = False


class Teleop:
    """Turns keys into requested velocities, each valid for HOLD_S."""

    def __init__(self) -> None:
        self._key: OperatorKey | None = None

    def press(self, key: OperatorKey) -> None:
        """Set the key in force, in place of the one before."""
        self._key = key

    def requested(self, t: float) -> tuple[float, float]:
        """Return the requested (v m/s, w rad/s) at t: v >= 0, both 0 without a valid key."""
        key = self._key
        if key is None or not 0.0 <= t - key.t < HOLD_S:
            return 0.0, 0.0
        ahead, left = min(max(key.ahead, 0), 1), min(max(key.left, -1), 1)
        return ahead * _SPEED, left * _TURN_RATE
