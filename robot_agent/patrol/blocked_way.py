"""Whether a robot that no longer moves closes the way round the border.

A teammate that comes from ahead drives 0.3 m and more in the 0.9 s from first sight until it turns
the robot back; one that stands does not. It may be turning itself, so only the second such meeting
at one place shows that it will not go away.
"""

from __future__ import annotations

from maps.border import Border
from robot_agent.patrol.held_at_place import HeldAtPlace
from robot_agent.patrol.situation import Situation
from robot_agent.patrol.turn_log import Turn, TurnCause

STANDS_RADIUS = 0.2  # m; a tracked teammate that stands stays within it
STANDS_S = 1.2  # s within it: from first sight to the turn 1.7 s pass before one that stands
LOST_S = 1.0  # s out of sight after which it is another one
ONE_PLACE = 1.0  # m of abscissa; with ``closing_in`` the robot turns back 0.5 m later


class BlockedWay:
    """Remembers where a standing teammate turned the robot back, by its new direction."""

    def __init__(self, border: Border) -> None:
        self._border = border
        self._stands = HeldAtPlace(STANDS_RADIUS, LOST_S)
        self._stood = 0.0  # s, in the last step
        self._latest: Turn | None = None
        self._before: dict[int, float] = {}  # abscissa, m

    def is_found(self, situation: Situation, latest: Turn | None) -> bool:
        """Return whether the last step's turn, if it had one, shows that the way is blocked.

        latest: the latest turn. Called in every step.
        """
        found = False
        if latest is not self._latest and latest is not None:
            found = latest.cause is TurnCause.TEAMMATE and self._is_again(latest)
        self._latest = latest
        mate = situation.teammate
        self._stood = 0.0 if mate is None else self._stands.update(situation.t, mate)
        return found

    def _is_again(self, turn: Turn) -> bool:
        if self._stood < STANDS_S:
            return False
        before = self._before.get(turn.direction)
        self._before[turn.direction] = turn.abscissa
        return (
            before is not None and abs(self._border.difference(turn.abscissa, before)) <= ONE_PLACE
        )
