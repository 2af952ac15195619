"""The P2OS handshake SYNC0, SYNC1, SYNC2, with the search for the robot's rate.

Source: Pioneer 2 Operations Manual, connecting; the ways out of trouble are those that clients of
these robots found necessary.
"""

from __future__ import annotations

from drivers.p2os.commands import CLOSE, HOST_BAUDS, OPEN, STOP, SYNCS
from drivers.p2os.robot_identity import RobotIdentity, decode_sync_reply
from drivers.requests import Request, SetBaud, Write

REPLY_TIMEOUT = 0.5  # s
TRIES_PER_RATE = 2
SETTLING_TIME = 0.3  # s, in which replies to earlier commands run dry
SYNC_TROUBLE = 0xFF
"""Type of the packet by which a controller says that the handshake must start over."""


class Handshake:
    """Brings a robot from any state to the point where OPEN starts its servers.

    Every attempt begins with STOP: a robot still in an earlier session takes SYNC0 for PULSE and
    would resume that session's motion.
    """

    def __init__(self, baud: int, requests: list[Request]) -> None:
        self.attempts = 0
        self.old_sessions = 0
        self.rate_changes = 0
        self._requests = requests
        self._rates = [baud, *(rate for rate in HOST_BAUDS if rate != baud)]
        self._rate = 0
        self._tries = 0
        self._expected = 0
        self._deadline = 0.0
        self._settling = False

    @property
    def baud(self) -> int:
        """Rate in use."""
        return self._rates[self._rate]

    def start(self, t: float, *, at_configured_rate: bool) -> None:
        """Begin, at the configured rate or at the one that worked last."""
        if at_configured_rate:
            self._use_rate(0)
        self._tries = 0
        self._attempt(t)

    def feed(self, data: bytes, t: float) -> RobotIdentity | None:
        """Take a packet; return the robot's identity when it completes the handshake."""
        if self._settling:
            return None
        if data[0] == SYNC_TROUBLE:
            self._settle(t)
        elif data[0] > 2:
            self._close_old_session(t)
        elif self._expected == 2 and (identity := decode_sync_reply(data)) is not None:
            return identity
        elif self._expected < 2 and data[0] == self._expected:
            self._send_sync(self._expected + 1, t)
        else:
            self._settle(t)
        return None

    def tick(self, t: float) -> None:
        """Try again once a reply is overdue; after TRIES_PER_RATE go to the next rate."""
        if t < self._deadline:
            return
        if self._settling:
            self._tries = 0
        elif self._tries >= TRIES_PER_RATE:
            self._tries = 0
            self.rate_changes += 1
            self._use_rate((self._rate + 1) % len(self._rates))
        self._attempt(t)

    def _attempt(self, t: float) -> None:
        self._settling = False
        self._tries += 1
        self.attempts += 1
        self._write(STOP.encode())
        if self._tries > 1:
            # A robot that got SYNC2 but whose reply was lost only answers to OPEN.
            self._write(OPEN.encode())
        self._send_sync(0, t)

    def _send_sync(self, number: int, t: float) -> None:
        self._expected = number
        self._deadline = t + REPLY_TIMEOUT
        self._write(SYNCS[number].encode())

    def _close_old_session(self, t: float) -> None:
        self.old_sessions += 1
        self._write(STOP.encode())
        self._write(CLOSE.encode())
        if self._rate != 0:
            self._use_rate(0)  # a closed controller falls back to the rate it starts with
        self._settle(t)

    def _settle(self, t: float) -> None:
        self._settling = True
        self._deadline = t + SETTLING_TIME

    def _use_rate(self, index: int) -> None:
        self._rate = index
        self._requests.append(SetBaud(self.baud))

    def _write(self, data: bytes) -> None:
        self._requests.append(Write(data))
