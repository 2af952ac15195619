"""Rate-limited sending of commands to a robot in a session.

A P2OS controller executes about one command in each of its cycles of 50 ms (Pioneer 2 Operations
Manual, 1999), later firmware one in 5 ms (H8-series manual). A few may arrive together.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable

from drivers.p2os.commands import STOP, Command
from drivers.requests import Request, Write

P2OS_PERIOD = 0.050  # s per command, on average
LATER_PERIOD = 0.005  # s
BURST = 2
"""Most commands that are sent together after a pause, and by one call of ``flush``."""
DEFAULT_WATCHDOG = 2.0  # s


class CommandOutbox:
    """Writes commands to ``requests``: urgent ones at once, queued ones at the controller's rate.

    ``note_sent(command, t)`` is called for every command sent.
    """

    def __init__(
        self, requests: list[Request], note_sent: Callable[[Command, float], None]
    ) -> None:
        self.period = P2OS_PERIOD
        self.watchdog = DEFAULT_WATCHDOG
        """Time without a packet, s, after which the controller halts until the next packet."""
        self.last_sent = -math.inf
        self._requests = requests
        self._note_sent = note_sent
        self._queue: deque[Command] = deque()
        self._credit = float(BURST)
        self._credited_at = -math.inf

    @property
    def empty(self) -> bool:
        """Whether nothing is queued."""
        return not self._queue

    def restart(self, t: float) -> None:
        """Clear the queue and assume P2OS's period and watchdog; a session opens at ``t``."""
        self._queue.clear()
        self.period = P2OS_PERIOD
        self.watchdog = DEFAULT_WATCHDOG
        self.last_sent = t

    def add(self, *commands: Command) -> None:
        """Queue commands, in order."""
        self._queue.extend(commands)

    def drop_queued(self) -> None:
        """Clear the queue."""
        self._queue.clear()

    def flush(self, t: float) -> None:
        """Send the part of the queue that the controller can take now."""
        for _ in range(min(BURST, len(self._queue))):
            if self.has_room(t):
                self.send(self._queue.popleft(), t)

    def has_room(self, t: float) -> bool:
        """Whether the controller can take another command now."""
        self._earn_credit(t)
        return self._credit >= 1.0 - 1e-6

    def send(self, command: Command, t: float) -> None:
        """Send at once: for commands that stop the robot or open and close its servers.

        After the watchdog has halted the robot any packet would make it resume its old motion, so
        STOP is sent first.
        """
        if t - self.last_sent >= self.watchdog and command != STOP:
            self._write(STOP, t)
        self._write(command, t)

    def _earn_credit(self, t: float) -> None:
        elapsed = max(0.0, t - self._credited_at)
        self._credit = min(BURST, self._credit + elapsed / self.period)
        self._credited_at = t

    def _write(self, command: Command, t: float) -> None:
        self._earn_credit(t)
        self._credit -= 1.0
        self.last_sent = t
        self._note_sent(command, t)
        self._requests.append(Write(command.encode()))
