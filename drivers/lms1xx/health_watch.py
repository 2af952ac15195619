"""Keeps the scanner's health up to date: asks for its window when the status in its scans changes.

A question does not disturb the stream.
"""

from __future__ import annotations

from drivers.lms1xx.framing import Telegram
from drivers.lms1xx.health import LaserHealth, health_of
from drivers.lms1xx.telegrams import READ_CONTAMINATION, Contamination, decode_byte, reply_to

PAUSE = 5.0  # s between questions, however often the status changes


class HealthWatch:
    """The scanner's last known condition; None until it has said anything of it."""

    def __init__(self) -> None:
        self.health: LaserHealth | None = None
        self._status = 0
        self._contamination = Contamination.NONE
        self._asks = False
        self._next_question = 0.0

    def on_telegram(self, telegram: Telegram) -> None:
        """Take a reply; all but that of LCMstate are ignored."""
        if telegram.command != reply_to(READ_CONTAMINATION):
            return
        number = decode_byte(telegram)
        if number is not None and number in Contamination.__members__.values():
            self._contamination = Contamination(number)
            self.health = health_of(self._status, self._contamination)

    def on_scan_status(self, status: int) -> None:
        """Take the status of a scan."""
        if self.health is None or status != self._status:
            self._asks = status != self._status
            self._status = status
            self.health = health_of(status, self._contamination)

    def question_due(self, t: float) -> bool:
        """Return whether to ask the streaming scanner now for the state of its window."""
        if not self._asks or t < self._next_question:
            return False
        self._asks = False
        self._next_question = t + PAUSE
        return True
