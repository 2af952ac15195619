"""A device tried out for a moment: a real link and a real session, in real time, nothing moved."""

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
FAREWELL_S = 0.3
"""How long the last commands get to leave in their due order."""

T_co = TypeVar("T_co", covariant=True)
T = TypeVar("T")


class Session(Protocol[T_co]):
    """What the sessions of base and laser have in common."""

    def link_up(self, t: float) -> None:
        """Begin."""

    def link_down(self, t: float) -> None:
        """Forget what was under way."""

    def feed(self, data: bytes, t: float) -> Sequence[T_co]:
        """Take bytes; return the measurements they complete."""

    def tick(self, t: float) -> None:
        """Notice what is overdue."""

    def pop_requests(self) -> list[Request]:
        """Return what the link must do."""

    def shut_down(self, t: float) -> None:
        """Leave the device as it should be left."""


@dataclass(frozen=True, slots=True)
class _Heard:
    t: float
    what: bytes | str | None
    """Bytes received, why the link went down, or None when it came up."""


@dataclass(slots=True)
class LineRecord:
    """What happened on the line during a trial."""

    opened: bool = False
    lost: str = ""
    """Why the port could not be opened or was lost."""
    bauds_tried: list[int] = field(default_factory=list)
    bytes_heard: int = 0
    last_bytes: bytes = b""
    """The end of what was heard last."""
    last_bytes_baud: int = 0


class DeviceTrial(Generic[T]):
    """Brings one device's session up and listens until there was ``enough``.

    ``measurements`` holds (time of arrival s, measurement). The session stays readable afterwards.
    """

    def __init__(
        self,
        url: str,
        baud: int,
        session: Session[T],
        enough: Callable[[Sequence[tuple[float, T]]], bool],
    ) -> None:
        self.line = LineRecord()
        self.measurements: list[tuple[float, T]] = []
        self._session = session
        self._enough = enough
        self._inbox: SimpleQueue[_Heard] = SimpleQueue()
        self._link = Link(url, baud, self, time.monotonic)
        self._baud = baud
        self._next_tick = 0.0

    @property
    def done(self) -> bool:
        """Whether there is nothing more to wait for."""
        return bool(self.line.lost) or self._enough(self.measurements)

    # Called on the link's thread

    def received(self, t: float, data: bytes) -> None:
        """Take bytes that arrived."""
        self._inbox.put(_Heard(t, data))

    def link_up(self, t: float) -> None:
        """Take note that the port is open."""
        self._inbox.put(_Heard(t, None))

    def link_down(self, t: float, reason: str) -> None:
        """Take note that the port was lost or cannot be opened."""
        self._inbox.put(_Heard(t, reason))

    # Called by run_trials

    def start(self) -> None:
        """Open the port."""
        self._link.start()

    def serve(self) -> None:
        """Handle what was heard, and time."""
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
        """Say good-bye to the device."""
        self._session.shut_down(time.monotonic())
        self._carry_out()

    def close(self) -> None:
        """Close the port; idempotent."""
        self._link.close()

    def _on_item(self, heard: _Heard) -> None:
        line = self.line
        if heard.what is None:
            line.opened = True
            self._session.link_up(heard.t)
        elif isinstance(heard.what, str):
            line.lost = heard.what
            self._session.link_down(heard.t)
        else:
            line.bytes_heard += len(heard.what)
            line.last_bytes, line.last_bytes_baud = heard.what[-8:], self._baud
            for measurement in self._session.feed(heard.what, heard.t):
                self.measurements.append((heard.t, measurement))
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
        """Whether there is nothing more to wait for."""

    def start(self) -> None:
        """Open the port."""

    def serve(self) -> None:
        """Handle what was heard, and time."""

    def shut_down(self) -> None:
        """Say good-bye to the device."""

    def close(self) -> None:
        """Close the port."""


def run_trials(
    trials: Sequence[AnyTrial], limit: float, progress: Callable[[float], None] = lambda _: None
) -> None:
    """Run trials side by side until all are done, at most ``limit`` s; close every session."""
    started = time.monotonic()
    try:
        for trial in trials:
            trial.start()
        while (elapsed := time.monotonic() - started) < limit and not all(
            trial.done for trial in trials
        ):
            _serve(trials)
            progress(elapsed)
        for trial in trials:
            trial.shut_down()
        until = time.monotonic() + FAREWELL_S
        while time.monotonic() < until:
            _serve(trials)
    finally:
        for trial in trials:
            trial.close()


def _serve(trials: Sequence[AnyTrial]) -> None:
    for trial in trials:
        trial.serve()
    time.sleep(POLL_S)
