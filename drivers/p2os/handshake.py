"""The P2OS handshake SYNC0, SYNC1, SYNC2, with the search for the robot's rate.

Source: Pioneer 2 Operations Manual, connecting; recovery from failures as in existing clients.
"""

from __future__ import annotations

from drivers.p2os.commands import CLOSE, OPEN, STOP, SYNCS
from drivers.p2os.extended_packets import NOTIFICATION_TYPES
from drivers.p2os.rate_search import RateSearch
from drivers.p2os.robot_identity import RobotIdentity, decode_sync_reply
from drivers.p2os.trouble import Trouble, TroubleKind
from drivers.requests import Request, SetBaud, Write

LISTENING_TIME = 0.25  # s, more than two cycles of reports
REPLY_TIMEOUT = 0.5  # s
SETTLING_TIME = 0.3  # s, for replies to earlier commands to end
PATIENCE = 3  # times the same failure occurs before it becomes ``trouble``
KEPT_BYTES = 8  # bytes
ECHOES = frozenset(command.encode()[3:-2] for command in (STOP, OPEN, CLOSE, SYNCS[2]))
"""Packets that no robot sends: received, they show that the port echoes."""


class Handshake:
    """Brings a robot from any state to the point where OPEN starts its servers.

    A robot still in a session takes SYNC0 for PULSE and would resume that session's motion, but
    it also sends reports: so the handshake listens before the first SYNC0 and stops a robot that
    reports. STOP is sent unconditionally only where there was a session on this line: some servers
    take any first packet but SYNC0 for the end of the handshake. ``trouble`` is the reason why
    there is no robot yet, or None.
    """

    def __init__(self, baud: int, requests: list[Request]) -> None:
        self.attempts = 0
        self.old_sessions = 0
        self.sweeps = 0
        """Searches of every rate that found no robot."""
        self.trouble: Trouble | None = None
        self.rates = RateSearch(baud)
        self._requests = requests
        self._tries = 0
        self._expected = 0
        self._deadline = 0.0
        self._settling = False
        self._in_session = False
        self._received = b""
        self._failures: dict[TroubleKind, int] = {}

    @property
    def baud(self) -> int:
        """Present rate."""
        return self.rates.baud

    def start(self, t: float, *, in_session: bool = False) -> None:
        """Begin, at the rate of the last success if there was one.

        in_session: the robot was in a session of this client on this line and fell silent.
        """
        self.trouble = None
        self._in_session = in_session
        self._received = b""
        self._failures.clear()
        self.rates.restart()
        self._requests.append(SetBaud(self.baud))
        self._begin_rate(t)

    def on_bytes(self, data: bytes) -> None:
        """Keep the last bytes received, for messages."""
        self._received = (self._received + data)[-KEPT_BYTES:]

    def feed(self, data: bytes, t: float) -> RobotIdentity | None:
        """Take a packet; return the robot's identity when it completes the handshake."""
        if data in ECHOES:
            why = "the port echoes what is sent: loop-back plug, radio modem?"
            self._settle(Trouble(TroubleKind.ECHO, why), t)
        elif self._settling:
            return None
        elif data[0] in NOTIFICATION_TYPES:
            why = "robot refuses the handshake again and again: press its RESET"
            self._settle(Trouble(TroubleKind.REFUSED, why), t)
        elif data[0] > 2:
            self._close_old_session(t)
        elif self._expected == 2 and (identity := decode_sync_reply(data)) is not None:
            self.trouble = None
            self.rates.on_success()
            return identity
        elif self._expected < 2 and data[0] == self._expected:
            self._send_sync(self._expected + 1, t)
        else:
            why = "robot answers the handshake out of order: press its RESET"
            self._settle(Trouble(TroubleKind.OUT_OF_ORDER, why), t)
        return None

    def tick(self, t: float) -> None:
        """Try again once a reply is overdue; after a rate's number of tries go to the next rate."""
        if t < self._deadline:
            return
        if self._settling:
            self._tries = 0
        if self._tries >= self.rates.tries:
            self._next_rate()
            self._begin_rate(t)
        else:
            self._attempt(t)

    def _begin_rate(self, t: float) -> None:
        """Listen at a rate before the first attempt."""
        self._tries = 0
        if self._in_session:
            self._attempt(t)
        else:
            self._settling = False
            self._expected = 0  # a reply to another client's SYNC0 counts too
            self._deadline = t + LISTENING_TIME

    def _attempt(self, t: float) -> None:
        self._settling = False
        self._tries += 1
        self.attempts += 1
        if self._in_session:
            self._write(STOP.encode())
        elif self._tries > 1:
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
        if self.rates.return_to_configured():
            # A closed controller falls back to the rate it starts with.
            self._requests.append(SetBaud(self.baud))
        why = (
            "robot sends reports but does not end its old session: sending wire broken? "
            "else press its RESET"
        )
        self._settle(Trouble(TroubleKind.OLD_SESSION, why), t)

    def _next_rate(self) -> None:
        if self.rates.advance():
            self.sweeps += 1
            self.trouble = self._no_robot()
        self._requests.append(SetBaud(self.baud))

    def _no_robot(self) -> Trouble:
        rates = ", ".join(map(str, self.rates.all))
        if not self._received:
            words = f"no reply at {rates} baud: robot switched on? cable? last bytes heard: none"
            return Trouble(TroubleKind.NO_REPLY, words)
        received = self._received.hex(" ")
        words = (
            f"only noise at {rates} baud: is this the robot's port? last bytes heard: {received}"
        )
        return Trouble(TroubleKind.NOISE, words)

    def _settle(self, why: Trouble, t: float) -> None:
        self._settling = True
        self._deadline = t + SETTLING_TIME
        times = self._failures.get(why.kind, 0) + 1
        self._failures[why.kind] = times
        if times >= PATIENCE:
            heard = f"last bytes heard: {self._received.hex(' ')}"
            self.trouble = Trouble(why.kind, f"{why.words}; {heard}")

    def _write(self, data: bytes) -> None:
        self._requests.append(Write(data))
