"""State of the motors' power: on, off, being enabled, cut by the stop button."""

from __future__ import annotations

import math
from enum import StrEnum

from drivers.p2os.base_state import BaseState
from drivers.p2os.trouble import Trouble, TroubleKind

ENABLE_RETRY = 0.5  # s
ENABLE_PATIENCE = 3.0  # s


class MotorState(StrEnum):
    """State of the motors' power."""

    UNKNOWN = "unknown"  # no report yet
    OFF = "off"  # not enabled by this client
    ENABLING = "enabling"  # ENABLE sent, not confirmed by a report
    ON = "on"
    STOP_BUTTON = "stop button"  # a person has switched them off; only a person may end that


class MotorWatch:
    """Tracks the motors' power through reports and commands.

    Later firmware reports its stop button. P2OS does not: there motors that go off while enabled,
    without a stall or a command, mean the button. Either way the state is latched until a report
    shows that a person has switched them on again by the MOTORS button.
    """

    def __init__(self) -> None:
        self.state = MotorState.UNKNOWN
        self._enabling_since = self._last_enable = math.inf
        self._button_held = False

    @property
    def may_enable(self) -> bool:
        """Whether the motors are off and no person has switched them off."""
        return self.state is MotorState.OFF

    def on_enable(self, t: float) -> None:
        """Note that ENABLE 1 was queued at ``t``."""
        if self.state is not MotorState.ENABLING:
            self._enabling_since = t
        self.state = MotorState.ENABLING
        self._last_enable = t

    def is_overdue(self, t: float) -> bool:
        """Whether ENABLE 1 must be sent again."""
        return self.state is MotorState.ENABLING and t - self._last_enable >= ENABLE_RETRY

    def update(self, base: BaseState, *, commands_pending: bool) -> None:
        """Take a report; while commands are pending it does not confirm ENABLE."""
        before = self.state
        self._button_held = base.stop_button
        if base.stop_button:
            self.state = MotorState.STOP_BUTTON
        elif base.motors_enabled:
            if before is not MotorState.ENABLING or not commands_pending:
                self.state = MotorState.ON
        elif before is MotorState.ON and not (base.stall_left or base.stall_right):
            self.state = MotorState.STOP_BUTTON
        elif before not in (MotorState.STOP_BUTTON, MotorState.ENABLING):
            self.state = MotorState.OFF

    def trouble(self, t: float) -> Trouble | None:
        """Return why enabled motors are off; None if there is no trouble."""
        if self.state is MotorState.STOP_BUTTON:
            release = "release it and " if self._button_held else ""
            words = f"stopped by the robot's stop button: {release}press MOTORS on the robot"
            return Trouble(TroubleKind.STOP_BUTTON, words)
        if self.state is MotorState.ENABLING and t - self._enabling_since > ENABLE_PATIENCE:
            words = "motors do not come on: is a stop button pressed, the battery low?"
            return Trouble(TroubleKind.MOTORS_OFF, words)
        return None
