"""Runs one device's session on its link for a short time, without moving anything."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from queue import Empty, SimpleQueue
from typing import Generic, Protocol, TypeVar

from drivers.link import Link
from drivers.requests import Request, SetBaud

TICK_S = 0.05
POLL_S = 0.01
CLOSING_S = 0.3
"""Time for the last commands to be sent in order."""
LONGEST_S = 60.0
"""Longest trial of a device that answers slowly."""

T_co = TypeVar("T_co", covariant=True)
T = TypeVar("T")


class Session(Protocol[T_co]):
    """Common interface of the base's and the laser's sessions."""

    def link_up(self, t: float) -> None:
        """Start the session."""

    def link_down(self, t: float) -> None:
        """Reset the session."""

    def feed(self, data: bytes, t: float) -> Sequence[T_co]:
        """Decode bytes; return the measurements they complete."""

    def tick(self, t: float) -> None:
        """Handle time-outs."""

    def pop_requests(self) -> list[Request]:
        """Return and remove the requests to the link."""

    def shut_down(self, t: float) -> None:
        """Request the commands that close the session and leave the device at rest."""


@dataclass(frozen=True, slots=True)
class _LineEvent:
    t: float
    content: bytes | str | None
    """Bytes received, the reason of a lost link, or None for a link that came up."""


@dataclass(slots=True)
class LineRecord:
    """Record of the line during a trial."""

    opened: bool = False
    opened_at: float = 0.0
    """Monotonic time, s."""
    lost: str = ""
    """Reason why the port could not be opened or was lost; empty: it was not."""
    bauds_tried: list[int] = field(default_factory=list)
    bytes_received: int = 0
    last_bytes: bytes = b""
    """The last 8 bytes, at most, of the last piece received."""
    last_bytes_baud: int = 0


class DeviceTrial(Generic[T]):
    """Runs one device's session until ``enough(measurements)`` is true.

    ``measurements`` holds (monotonic time of arrival, measurement). The session can be read
    afterwards. ``answers()``: whether the device answers, if slowly, and measurements may come.
    """

    def __init__(
        self,
        url: str,
        baud: int,
        session: Session[T],
        enough: Callable[[Sequence[tuple[float, T]]], bool],
        answers: Callable[[], bool] = lambda: False,
    ) -> None:
        self.line = LineRecord()
        self.measurements: list[tuple[float, T]] = []
        self._session = session
        self._enough = enough
        self._answers = answers
        self._inbox: SimpleQueue[_LineEvent] = SimpleQueue()
        self._link = Link(url, baud, self, time.monotonic)
        self._baud = baud
        self._next_tick = 0.0
        self._ended = False

    @property
    def done(self) -> bool:
        """Whether the port was lost or there are enough measurements."""
        return bool(self.line.lost) or self._enough(self.measurements)

    @property
    def goes_on(self) -> bool:
        """Whether more time may bring what is missing."""
        return not self.done and self._answers()

    # Called on the link's thread

    def received(self, t: float, data: bytes) -> None:
        """Queue bytes received."""
        self._inbox.put(_LineEvent(t, data))

    def link_up(self, t: float) -> None:
        """Queue that the port is open."""
        self._inbox.put(_LineEvent(t, None))

    def link_down(self, t: float, reason: str) -> None:
        """Queue that the port was lost or cannot be opened."""
        self._inbox.put(_LineEvent(t, reason))

    # Called by run_trials

    def start(self) -> None:
        """Open the port."""
        self._link.start()

    def serve(self) -> None:
        """Handle queued events and tick the session; does not block."""
        try:
            while True:
                self._on_item(self._inbox.get_nowait())
        except Empty:
            pass
        now = time.monotonic()
        if now >= self._next_tick:
            self._next_tick = now + TICK_S
            self._session.tick(now)
        self._carry_out()

    def shut_down(self) -> None:
        """Send the commands that close the session; the device may close the connection then."""
        self._ended = True
        self._session.shut_down(time.monotonic())
        self._carry_out()
        self._link.end()

    def close(self) -> None:
        """Close the port; idempotent."""
        self._link.close()

    def _on_item(self, event: _LineEvent) -> None:
        line = self.line
        if self._ended and not isinstance(event.content, bytes):
            return
        if event.content is None:
            line.opened, line.opened_at = True, event.t
            self._session.link_up(event.t)
        elif isinstance(event.content, str):
            line.lost = event.content
            self._session.link_down(event.t)
        else:
            line.bytes_received += len(event.content)
            line.last_bytes, line.last_bytes_baud = event.content[-8:], self._baud
            for measurement in self._session.feed(event.content, event.t):
                self.measurements.append((event.t, measurement))
        self._carry_out()

    def _carry_out(self) -> None:
        for request in self._session.pop_requests():
            if isinstance(request, SetBaud):
                self._baud = request.baud
                if request.baud not in self.line.bauds_tried:
                    self.line.bauds_tried.append(request.baud)
                self._link.set_baud(request.baud)
            else:
                self._link.write(request.data)


class AnyTrial(Protocol):
    """A trial of any kind of measurement."""

    @property
    def done(self) -> bool:
        """Whether the trial is over."""

    @property
    def goes_on(self) -> bool:
        """Whether more time may bring what is missing."""

    def start(self) -> None:
        """Open the port."""

    def serve(self) -> None:
        """Handle queued events and tick the session."""

    def shut_down(self) -> None:
        """Send the commands that close the session."""

    def close(self) -> None:
        """Close the port."""


def run_trials(
    trials: Sequence[AnyTrial], limit: float, progress: Callable[[float], None] = lambda _: None
) -> None:
    """Run trials concurrently until all are done, at most ``limit`` s; close sessions and ports.

    Devices that answer slowly have LONGEST_S. progress: called with the elapsed time, s.
    """
    started = time.monotonic()
    try:
        for trial in trials:
            trial.start()
        while not all(trial.done for trial in trials):
            elapsed = time.monotonic() - started
            slow = elapsed < LONGEST_S and any(trial.goes_on for trial in trials)
            if elapsed >= limit and not slow:
                break
            _serve(trials)
            progress(elapsed)
        for trial in trials:
            trial.shut_down()
        until = time.monotonic() + CLOSING_S
        while time.monotonic() < until:
            _serve(trials)
    finally:
        for trial in trials:
            trial.close()


def _serve(trials: Sequence[AnyTrial]) -> None:
    for trial in trials:
        trial.serve()
    time.sleep(POLL_S)
