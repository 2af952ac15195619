"""An object on the border that is no teammate: after a while the robot stops waiting for it.

Not in the paper, whose border is free.
"""

from __future__ import annotations

from robot_agent.patrol.actions import Action
from robot_agent.patrol.held_at_place import HeldAtPlace
from robot_agent.patrol.modifier import Override, OverrideReason
from robot_agent.patrol.situation import Situation
from robot_agent.patrol.supervisor import Choice
from robot_agent.patrol.turn_log import TurnCause

_PATIENCE = 10.0  # s an object may hold the robot before it turns back
_MOVED = 0.15  # m; a robot that got so far is not held at one place
_PAUSE = 1.0  # s without being held that end it; the gate's noise is shorter
_TEAMMATE_NEAR = 1.0  # m; a teammate so near may be the object, and is waited for


class Blockage:
    """Turns a robot that an object has held at one place for long."""

    def __init__(self) -> None:
        self._held = HeldAtPlace(_MOVED, _PAUSE)

    def propose(
        self,
        situation: Situation,
        choice: Choice,  # noqa: ARG002 - waits whatever the rules choose
        action: Action,  # noqa: ARG002
    ) -> Override | None:
        """Turn back once the patience is at an end, then wait anew."""
        if situation.neighbor.distance < _TEAMMATE_NEAR:
            self._held.forget()
            return None
        if not situation.held:
            return None
        if self._held.update(situation.t, situation.position) < _PATIENCE:
            return None
        self._held.forget()
        return Override(OverrideReason.BLOCKAGE, turn=TurnCause.BLOCKAGE)
