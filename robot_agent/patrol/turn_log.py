"""Log of a robot's turns on its border, shared by all modifiers that depend on them."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from enum import StrEnum

import msgspec

_KEPT = 256  # turns


class TurnCause(StrEnum):
    """Why a robot turned back."""

    TEAMMATE = "teammate"  # by the rules, away from a teammate ahead
    RULES = "rules"  # by the rules otherwise: at an end of the border, or a teammate behind
    CHANCE = "chance"  # the paper's random reversal
    BLOCKAGE = "blockage"  # an object on its way that did not move
    EVEN_GAPS = "even_gaps"  # to leave the team evenly spaced
    COMMON = "common"  # together with the team, at a moment of the shared secret


class Turn(msgspec.Struct, frozen=True):
    """A turn at t at an abscissa, m, to a direction (+1 clockwise, -1), with its cause."""

    t: float
    abscissa: float
    direction: int
    cause: TurnCause


class TurnLog:
    """The latest turns of one robot."""

    def __init__(self) -> None:
        self._turns: deque[Turn] = deque(maxlen=_KEPT)

    @property
    def latest(self) -> Turn | None:
        """The latest turn; None before the first."""
        return self._turns[-1] if self._turns else None

    def add(self, turn: Turn) -> None:
        """Append a turn."""
        self._turns.append(turn)

    def latest_first(self, cause: TurnCause, direction: int) -> Iterator[Turn]:
        """Yield the turns of one cause to one direction, from the latest back."""
        return (
            turn
            for turn in reversed(self._turns)
            if turn.cause is cause and turn.direction == direction
        )
