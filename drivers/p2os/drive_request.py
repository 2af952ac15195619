"""The requested velocity as VEL and RVEL arguments, and when each was last sent."""

from __future__ import annotations

import math

from drivers.p2os.command_numbers import CommandNumber
from drivers.p2os.commands import Command
from drivers.p2os.settings import BaseSettings

REFRESH_PERIOD = 0.25  # s
STALE_AFTER = 0.3  # s


class DriveRequest:
    """Converts a velocity in m/s and rad/s to the commands that are due; knows its age."""

    def __init__(self, settings: BaseSettings) -> None:
        self._top_speed = settings.max_speed
        self._top_turn_rate = settings.max_turn_rate
        self.reset()

    def reset(self) -> None:
        """Forget the request and the commands sent."""
        self._wanted: dict[CommandNumber, int] = {}
        self._sent: dict[CommandNumber, tuple[int, float]] = {}
        self._set_at = -math.inf

    @property
    def moving(self) -> bool:
        """Whether the last VEL or RVEL sent is not zero."""
        return any(value != 0 for value, _ in self._sent.values())

    def is_stale(self, t: float) -> bool:
        """Whether motion is requested or under way and the last request is too old."""
        wanted = self.moving or any(self._wanted.values())
        return wanted and t - self._set_at > STALE_AFTER

    def set(self, t: float, v: float, w: float) -> None:
        """Request ``v`` m/s and ``w`` rad/s, clamped to the settings.

        A request that is not finite means standstill.
        """
        self._set_at = t
        if not (math.isfinite(v) and math.isfinite(w)):
            v = w = 0.0
        speed = max(-self._top_speed, min(self._top_speed, v))
        turn_rate = max(-self._top_turn_rate, min(self._top_turn_rate, w))
        self._wanted = {
            CommandNumber.VEL: round(1000.0 * speed),
            CommandNumber.RVEL: round(math.degrees(turn_rate)),
        }

    def zero(self) -> None:
        """Replace the request by standstill; its age stays."""
        self._wanted = dict.fromkeys(self._wanted, 0)

    def due(self, t: float) -> list[Command]:
        """Return the commands to send: changed values and those to refresh, the oldest first."""
        due = [
            (self._sent_at(number), Command(number, value))
            for number, value in self._wanted.items()
            if self._is_changed(number) or t - self._sent_at(number) >= REFRESH_PERIOD - 1e-9
        ]
        return [command for _, command in sorted(due, key=lambda pair: pair[0])]

    def changed(self) -> list[Command]:
        """Return the commands whose values have not been sent yet."""
        return [Command(n, value) for n, value in self._wanted.items() if self._is_changed(n)]

    def on_sent(self, command: Command, t: float) -> None:
        """Note a VEL or RVEL that was sent at ``t``; STOP counts as both at zero."""
        if command.number == CommandNumber.STOP:
            for number in (CommandNumber.VEL, CommandNumber.RVEL):
                self._sent[number] = (0, -math.inf)
        elif command.number in (CommandNumber.VEL, CommandNumber.RVEL):
            self._sent[CommandNumber(command.number)] = (command.integer, t)

    def _is_changed(self, number: CommandNumber) -> bool:
        return number not in self._sent or self._sent[number][0] != self._wanted[number]

    def _sent_at(self, number: CommandNumber) -> float:
        return self._sent[number][1] if number in self._sent else -math.inf
