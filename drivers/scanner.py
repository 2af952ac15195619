"""A laser scanner of any kind: its settings, and the session that serves it."""

from __future__ import annotations

import math
from typing import Any, Protocol

from drivers.lms1xx.session import Lms1xxSession
from drivers.lms1xx.settings import LaserSettings as Lms1xxSettings
from drivers.lms200.session import Lms200Session
from drivers.lms200.settings import LaserSettings as Lms200Settings
from drivers.mounting import Mounting
from drivers.requests import Request
from drivers.scan import Scan

ScannerSettings = Lms200Settings | Lms1xxSettings
"""Told apart by ``laser.kind``."""
DEFAULT_KIND = "lms200"
_LOOKS = 0.1  # s between two scans by which an LMS 1xx serves to locate: the agent's decisions
STREAMING = "streaming"
"""State of a session of any kind to which scans come."""
DOWN = "down"
"""State of a session of any kind without a port."""


class FramerCounters(Protocol):
    """Counts of the bytes and frames received."""

    @property
    def good(self) -> int:
        """Complete frames."""

    @property
    def bad_checksum(self) -> int:
        """Frames whose checksum was wrong."""

    @property
    def discarded_bytes(self) -> int:
        """Bytes that belong to no complete frame."""


class Framer(Protocol):
    """What finds the frames in a byte stream."""

    @property
    def counters(self) -> FramerCounters:
        """Counts since the session was made."""


class ScannerHealth(Protocol):
    """A scanner's condition as it reports it."""

    @property
    def ok(self) -> bool:
        """Whether there is no warning, error or flag."""

    @property
    def pollution(self) -> bool:
        """Whether the front window is dirty."""

    @property
    def text(self) -> str:
        """The condition in one line for people, with what to do about it."""


class ScannerSession(Protocol):
    """Brings a scanner from any state to streaming, and keeps it streaming; sans-I/O.

    After every call take ``pop_requests()`` and execute them in order.
    """

    @property
    def state(self) -> str:
        """State of the session; STREAMING when scans come."""

    @property
    def counters(self) -> Any:
        """Counts since the session was made, a dataclass."""

    @property
    def framer(self) -> Framer:
        """The framer of the bytes from the scanner."""

    @property
    def identity(self) -> str | None:
        """What the scanner says it is; None until it has."""

    @property
    def trouble(self) -> str | None:
        """Why there are no scans, or which setting was refused, for people; None: all is as set."""

    @property
    def health(self) -> ScannerHealth | None:
        """The scanner's condition; None until the first report."""

    @property
    def manner(self) -> str:
        """How it is spoken to, for people: its rate or dialect."""

    def link_up(self, t: float) -> None:
        """Start: the port is open."""

    def link_down(self, t: float) -> None:
        """Drop requests and unfinished telegrams: the port is closed."""

    def remount(self, mounting: Mounting) -> None:
        """Take another mounting."""

    def shut_down(self, t: float) -> None:
        """Stop the stream and end; ``link_up`` starts again."""

    def pop_requests(self) -> list[Request]:
        """Return and clear the requests to the link, in order."""

    def feed(self, data: bytes, t: float) -> list[Scan]:
        """Take bytes the last of which arrived at ``t``; return the scans they complete."""

    def tick(self, t: float) -> None:
        """Handle timeouts."""


def kind_of(settings: ScannerSettings) -> str:
    """Return ``laser.kind``."""
    return str(type(settings).__struct_config__.tag)


def look_period(settings: ScannerSettings) -> float:
    """Return the time, s, for which one scan serves to locate, track and tell.

    Every scan counts as an obstacle. Of a fast scanner one for each decision is enough for the
    rest; of an LMS 200 all are taken.
    """
    if not isinstance(settings, Lms1xxSettings):
        return 0.0
    period = settings.scan_period
    return (max(math.floor(_LOOKS / period + 1e-9), 1) - 0.5) * period


def scanner_session(settings: ScannerSettings) -> ScannerSession:
    """Return a session for a scanner of the configured kind."""
    if isinstance(settings, Lms1xxSettings):
        return Lms1xxSession(settings)
    return Lms200Session(settings)
