"""Modifier ``blockage`` for many robots at once."""

from __future__ import annotations

from robot_agent.patrol import blockage
from robot_agent.patrol.modifier import OverrideReason
from robot_agent.patrol.turn_log import TurnCause
from tools.batch.arbiters import Choices
from tools.batch.arrays import Codes, Indices
from tools.batch.held_places import HeldPlaces
from tools.batch.situations import Overrides, Situations


class Blockages:
    """Turns robots back once an object has held them at one place for the timeout."""

    def __init__(self, n: int) -> None:
        self._held = HeldPlaces(n, blockage.MOVED, blockage.PAUSE)

    def pick(self, robots: Indices) -> None:
        """Keep some robots, as ``arrays.pick`` does."""
        self._held.pick(robots)

    def propose(
        self,
        at: Situations,
        choices: Choices,  # noqa: ARG002 - waits whatever the rules choose
        action: Codes,  # noqa: ARG002
        found: Overrides,
    ) -> Indices:
        """Put a turn where the timeout has passed; it then starts again."""
        near = at.neighbor < blockage.TEAMMATE_NEAR
        self._held.forget(near.nonzero()[0])
        some = (at.held & ~near).nonzero()[0]
        if some.size:
            some = some[self._held.update(some, at.t, at.x, at.y) >= blockage.TIMEOUT]
            self._held.forget(some)
            found.put(some, OverrideReason.BLOCKAGE, turn=TurnCause.BLOCKAGE)
        return some
