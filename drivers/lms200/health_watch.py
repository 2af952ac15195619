"""Keeps the laser's health up to date: queries it at the start and when its status byte changes.

A query may suspend the stream (the listing says "suspended by requests"), so queries are few, and
a stream that does not resume by itself is started again.
"""

from __future__ import annotations

from drivers.lms200 import telegrams
from drivers.lms200.errors import ErrorEntry, decode_errors
from drivers.lms200.framing import Telegram
from drivers.lms200.health import LaserHealth, health_of
from drivers.lms200.telegrams import Command, DeviceStatus

STEP_LIMIT = 0.5  # s for a reply or for the next scan, before the next step
PAUSE = 5.0  # s between series of queries, however often the status byte changes


class HealthWatch:
    """The laser's last known condition, and the next command to query it.

    ``health`` is None until the laser has answered once.
    """

    def __init__(self) -> None:
        self.health: LaserHealth | None = None
        self._status: int | None = None  # the last status byte acted upon
        self._errors: tuple[ErrorEntry, ...] = ()
        self._defective = False
        self._status_changed = False
        self._steps: list[bytes] = []
        self._next_step = 0.0
        self._next_conversation = 0.0

    def restart(self) -> None:
        """Forget queries in progress: a new session queries the laser itself."""
        self._status = None
        self._status_changed = False
        self._steps.clear()

    def on_telegram(self, telegram: Telegram) -> None:
        """Take a reply; all but B1 and B2 are ignored."""
        if telegram.code == Command.ERRORS.reply:
            self._errors = decode_errors(telegram)
        elif telegram.code == Command.STATUS.reply:
            status = DeviceStatus.decode(telegram)
            if status is None:
                return
            self._defective = status.defective
        else:
            return
        if self._status is None:
            self._status = telegram.payload[-1]
        self._conclude()
        self._next_step = 0.0  # answered: no need to wait

    def on_scan_status(self, status: int) -> None:
        """Take the status byte of a scan."""
        if self._steps == [telegrams.SELECT_CONTINUOUS]:
            self._steps.clear()  # the stream resumed by itself
        if status != self._status:
            self._status = status
            self._status_changed = True
            self._conclude()

    def next_command(self, t: float) -> bytes | None:
        """Return the command to send to the streaming laser now; None if there is none."""
        if self._steps and t >= self._next_step:
            self._next_step = t + STEP_LIMIT
            return self._steps.pop(0)
        if self._status_changed and not self._steps and t >= self._next_conversation:
            self._status_changed = False
            self._next_conversation = t + PAUSE
            self._next_step = t + STEP_LIMIT
            self._steps = [telegrams.READ_STATUS, telegrams.SELECT_CONTINUOUS]
            return telegrams.READ_ERRORS
        return None

    def _conclude(self) -> None:
        status = telegrams.STATUS_OK if self._status is None else self._status
        self.health = health_of(status, self._errors, defective=self._defective)
