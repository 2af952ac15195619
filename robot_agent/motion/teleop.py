"""Driving by the keys of the robot's own terminal, for mapping: no map, no pose, no patrol.

A key is good for a moment only: a released key, a lost terminal or a frozen process stops the
robot. What a key asks for goes through the gate's limited mode like any other request.
"""

from __future__ import annotations

from typing import Annotated

import msgspec

from robot_agent.messages.events import OperatorKey

_SPEED = 0.15  # m/s
_TURN_RATE = 0.4  # rad/s
HOLD_S = 0.7
"""How long a key is good for: longer than keyboards wait before they repeat it."""


class TeleopSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Whether the robot is driven by keys."""

    enabled: Annotated[
        bool,
        msgspec.Meta(
            description="Set by `patrol record`: an agent that obeys keys does nothing else."
        ),
    ] = False


class Teleop:
    """Turns keys into requested velocities, each for its moment."""

    def __init__(self) -> None:
        self._key: OperatorKey | None = None

    def press(self, key: OperatorKey) -> None:
        """Take a key; the last one counts."""
        self._key = key

    def requested(self, t: float) -> tuple[float, float]:
        """Return what is asked for at t, s: (v m/s, w rad/s), forwards or turning only."""
        key = self._key
        if key is None or not 0.0 <= t - key.t < HOLD_S:
            return 0.0, 0.0
        ahead, left = min(max(key.ahead, 0), 1), min(max(key.left, -1), 1)
        return ahead * _SPEED, left * _TURN_RATE
