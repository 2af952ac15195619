"""Modifier ``blockage``: turn back before an object on the border that is no teammate.

Not in the paper, which has no obstacles on the border.
"""

from __future__ import annotations

from robot_agent.patrol.actions import Action
from robot_agent.patrol.held_at_place import HeldAtPlace
from robot_agent.patrol.modifier import Override, OverrideReason
from robot_agent.patrol.situation import Situation
from robot_agent.patrol.supervisor import Choice
from robot_agent.patrol.turn_log import TurnCause

TIMEOUT = 10.0  # s an object may hold the robot before it turns back
MOVED = 0.15  # m; a robot that has moved farther is not held at one place
PAUSE = 1.0  # s without being held that reset the timeout; the gate flickers for less
TEAMMATE_NEAR = 1.0  # m; a teammate within this distance may be the object: wait


class Blockage:
    """Turns the robot back once an object has held it at one place for the timeout."""

    def __init__(self) -> None:
        self._held = HeldAtPlace(MOVED, PAUSE)

    def propose(
        self,
        situation: Situation,
        choice: Choice,  # noqa: ARG002 - waits whatever the rules choose
        action: Action,  # noqa: ARG002
    ) -> Override | None:
        """Return a turn once the timeout has passed (it then starts again), else None."""
        if situation.neighbor.distance < TEAMMATE_NEAR:
            self._held.forget()
            return None
        if not situation.held:
            return None
        if self._held.update(situation.t, situation.position) < TIMEOUT:
            return None
        self._held.forget()
        return Override(OverrideReason.BLOCKAGE, turn=TurnCause.BLOCKAGE)
