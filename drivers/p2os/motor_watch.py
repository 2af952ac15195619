"""Whether the motors have power, and who decided so."""

from __future__ import annotations

import math
from enum import StrEnum

from drivers.p2os.base_state import BaseState

ENABLE_RETRY = 0.5  # s
ENABLE_PATIENCE = 3.0  # s


class MotorState(StrEnum):
    """What is known of the motors' power."""

    UNKNOWN = "unknown"  # no report yet
    OFF = "off"  # nobody has asked for them
    ENABLING = "enabling"  # asked for, not reported yet
    ON = "on"
    STOP_BUTTON = "stop button"  # a person has switched them off; only a person may end that


class MotorWatch:
    """Follows the motors through reports and commands.

    Later firmware reports its stop button. P2OS does not: there the motors go off while enabled,
    with no stall and no command of ours. Either way they stay off until a report shows that a
    person has switched them on again by the MOTORS button.
    """

    def __init__(self) -> None:
        self.state = MotorState.UNKNOWN
        self._asked_at = self._asked_last = math.inf
        self._button_held = False

    @property
    def may_be_asked(self) -> bool:
        """Whether ENABLE would do what the session's owner wants and nobody forbids."""
        return self.state is MotorState.OFF

    def ask(self, t: float) -> None:
        """Note that ENABLE 1 is on its way."""
        if self.state is not MotorState.ENABLING:
            self._asked_at = t
        self.state = MotorState.ENABLING
        self._asked_last = t

    def is_overdue(self, t: float) -> bool:
        """Tell whether ENABLE 1 ought to be sent again."""
        return self.state is MotorState.ENABLING and t - self._asked_last >= ENABLE_RETRY

    def update(self, base: BaseState, *, commands_pending: bool) -> None:
        """Follow a report; while commands are pending it cannot be the answer to ENABLE."""
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

    def trouble(self, t: float) -> str | None:
        """Say, for people, why the motors are off though they should not be."""
        if self.state is MotorState.STOP_BUTTON:
            release = "release it and " if self._button_held else ""
            return f"stopped by the robot's stop button: {release}press MOTORS on the robot"
        if self.state is MotorState.ENABLING and t - self._asked_at > ENABLE_PATIENCE:
            return "motors do not come on: is a stop button pressed, the battery low?"
        return None
