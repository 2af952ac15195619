"""The motion asked of the robot, as VEL and RVEL arguments, and when each last went out."""

from __future__ import annotations

import math

from drivers.p2os.commands import Command, CommandNumber
from drivers.p2os.settings import BaseSettings

REFRESH_PERIOD = 0.25  # s
STALE_AFTER = 0.3  # s


class DriveWish:
    """Turns m/s and rad/s into the commands that are due; remembers how old the wish is."""

    def __init__(self, settings: BaseSettings) -> None:
        self._top_speed = settings.max_speed
        self._top_turn_rate = settings.max_turn_rate
        self._sent: dict[CommandNumber, tuple[int, float]] = {}
        self._asked_at = -math.inf

    @property
    def moving(self) -> bool:
        """Whether the robot was last told to move."""
        return any(value != 0 for value, _ in self._sent.values())

    def is_stale(self, t: float) -> bool:
        """Tell whether the robot was told to move by someone who has fallen silent."""
        return self.moving and t - self._asked_at > STALE_AFTER

    def commands(self, t: float, v: float, w: float) -> list[Command]:
        """Return what must go out for ``v`` m/s, ``w`` rad/s, clamped to the settings.

        A wish that is not finite is none: standstill.
        """
        self._asked_at = t
        if not (math.isfinite(v) and math.isfinite(w)):
            v = w = 0.0
        speed = max(-self._top_speed, min(self._top_speed, v))
        turn_rate = max(-self._top_turn_rate, min(self._top_turn_rate, w))
        wanted = (
            (CommandNumber.VEL, round(1000.0 * speed)),
            (CommandNumber.RVEL, round(math.degrees(turn_rate))),
        )
        return [Command(n, value) for n, value in wanted if self._is_due(n, value, t)]

    def note_sent(self, command: Command, t: float) -> None:
        """Remember a VEL or RVEL that went out; STOP counts as both at zero."""
        if command.number == CommandNumber.STOP:
            for number in (CommandNumber.VEL, CommandNumber.RVEL):
                self._sent[number] = (0, -math.inf)
        elif command.number in (CommandNumber.VEL, CommandNumber.RVEL):
            self._sent[CommandNumber(command.number)] = (command.integer, t)

    def _is_due(self, number: CommandNumber, value: int, t: float) -> bool:
        sent, sent_at = self._sent.get(number, (None, -math.inf))
        return sent != value or t - sent_at >= REFRESH_PERIOD - 1e-9
