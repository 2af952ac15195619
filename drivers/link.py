"""The live side of a device's line: one thread that opens it, reads, writes, and opens it again.

A lost port is opened again within half a second of its return. A serial adapter that returns under
another device name is found by its persistent name.
"""

from __future__ import annotations

import contextlib
import os
import select
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Protocol

from drivers.adapter_name import BY_ID, persistent_name
from drivers.port import Port, open_port
from drivers.port_error import PortError, PortTrouble
from drivers.requests import Request, SetBaud, Write

FIRST_PAUSE = 0.125  # s before the port is opened again; doubles
LONGEST_PAUSE = 0.5  # s: a cable's return must be noticed within a second
MAX_WAITING = 65536  # bytes accepted and not yet taken by the port
CLOSING_LIMIT = 0.5  # s for the last writes to leave


class LinkState(StrEnum):
    """State of a link."""

    CLOSED = "closed"
    OPENING = "opening"
    UP = "up"
    DOWN = "down"


@dataclass(frozen=True, slots=True)
class _End:
    """Place in the queue behind which nothing is written any more."""


class LinkListener(Protocol):
    """Callbacks of a link, called on its thread; ``t`` is by its clock."""

    def received(self, t: float, data: bytes) -> None:
        """Bytes arrived; the last of them was read at ``t``."""

    def link_up(self, t: float) -> None:
        """The port was opened."""

    def link_down(self, t: float, reason: str) -> None:
        """The port was lost or cannot be opened; called again only when the reason changes."""


@dataclass(slots=True)
class LinkCounters:
    """Traffic of a link since it was made."""

    bytes_in: int = 0
    bytes_out: int = 0
    bytes_dropped: int = 0  # written while the link was down
    overflows: int = 0  # times the port took no more bytes and was given up
    attempts: int = 0  # to open the port
    times_up: int = 0
    times_lost: int = 0


@dataclass(frozen=True, slots=True)
class LinkStatus:
    """A snapshot of a link, for people and telemetry.

    trouble, reason: why it is down, as a code and in words with a remedy; None and "" while up.
    port: the port last opened: the URL, or the adapter's new device name.
    """

    state: LinkState
    trouble: PortTrouble | None
    reason: str
    port: str


class Link:
    """Keeps a port open and reports to a listener what arrives and when it goes up or down.

    ``url``: serial device, pty path, ``socket://host:port`` or another URL of pyserial. The port is
    opened, and opened again after a loss, at ``baud``. ``write`` and ``set_baud`` only queue: they
    never block and never raise; failures are reported by ``link_down``. ``clock`` returns seconds.
    ``adapters`` is the folder of the adapters' persistent names.
    """

    def __init__(
        self,
        url: str,
        baud: int,
        listener: LinkListener,
        clock: Callable[[], float],
        adapters: Path = BY_ID,
    ) -> None:
        self.url = url
        self.state = LinkState.CLOSED
        self.reason = ""  # why the link is down
        self.trouble: PortTrouble | None = None  # the kind of reason
        self.counters = LinkCounters()
        self._adapters = adapters
        self._adapter: Path | None = None  # persistent name of the adapter last open
        self._port_name = url
        self._baud = baud
        self._listener = listener
        self._clock = clock
        self._lock = threading.Lock()
        self._queue: deque[Request | _End] = deque()
        self._waiting = 0  # bytes in the queue
        self._overflowed = False
        self._ended = False
        self._closing = threading.Event()
        self._wake_reader, self._wake_writer = -1, -1
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        """Start the thread, which calls the listener; RuntimeError if already started."""
        if self._thread is not None:
            raise RuntimeError("a link is started once")
        self._wake_reader, self._wake_writer = os.pipe()
        os.set_blocking(self._wake_reader, False)
        os.set_blocking(self._wake_writer, False)
        self._thread = threading.Thread(target=self._run, name=f"link {self.url}", daemon=True)
        self._thread.start()

    @property
    def status(self) -> LinkStatus:
        """A snapshot of the link now."""
        with self._lock:
            return LinkStatus(self.state, self.trouble, self.reason, self._port_name)

    @property
    def alive(self) -> bool:
        """Whether the thread runs; it ends only by ``close``, with a port that closes after
        ``end``, or by a programming error."""
        return self._thread is not None and self._thread.is_alive()

    def write(self, data: bytes) -> None:
        """Queue bytes, in order with changes of rate; dropped while the link is down."""
        self._enqueue(Write(data), len(data))

    def set_baud(self, baud: int) -> None:
        """Queue a change of rate: done when all earlier writes have left; drops unread input."""
        self._enqueue(SetBaud(baud), 0)

    def end(self) -> None:
        """Expect the other side to close the port once all earlier writes have left.

        That is no fault then: it is not reported, and the port is not opened again.
        """
        with self._lock:
            if self.state is LinkState.UP:
                self._queue.append(_End())
            else:
                self._ended = True
            self._wake()

    def close(self) -> None:
        """Let the last writes leave (at most 0.5 s), close the port, end the thread."""
        self._closing.set()
        with self._lock:
            self._wake()
        if self._thread is not None and self._thread is not threading.current_thread():
            self._thread.join()

    def _enqueue(self, request: Request, size: int) -> None:
        with self._lock:
            if self.state is not LinkState.UP:
                self.counters.bytes_dropped += size
            elif self._waiting + size > MAX_WAITING:
                self._overflowed = True
            else:
                self._queue.append(request)
                self._waiting += size
            self._wake()

    def _wake(self) -> None:
        """Call with the lock held: the pipe must not be closed meanwhile."""
        if self._wake_writer >= 0:
            with contextlib.suppress(BlockingIOError):  # full of wake-ups not yet seen
                os.write(self._wake_writer, b"\0")

    # The thread

    def _run(self) -> None:
        pause = FIRST_PAUSE
        while not (self._closing.is_set() or self._ended):
            heard_before = self.counters.bytes_in
            try:
                self._open_and_serve()
            except PortError as failure:
                if self._at_end:
                    break
                if self.counters.bytes_in > heard_before:
                    pause = FIRST_PAUSE
                self._go_down(failure)
            self._closing.wait(pause)
            pause = min(2 * pause, LONGEST_PAUSE)
        with self._lock:
            self.state = LinkState.CLOSED
            os.close(self._wake_reader)
            os.close(self._wake_writer)
            self._wake_reader = self._wake_writer = -1

    @property
    def _at_end(self) -> bool:
        """Whether everything before ``end`` has been written."""
        with self._lock:
            return self._ended or (bool(self._queue) and isinstance(self._queue[0], _End))

    def _open_and_serve(self) -> None:
        with self._lock:
            if self.state is LinkState.CLOSED:
                self.state = LinkState.OPENING
        self.counters.attempts += 1
        port = self._open()
        try:
            self._go_up()
            self._serve(port)
            self._finish_writes(port)
        finally:
            port.close()

    def _open(self) -> Port:
        """Open the adapter that was open before under its present device name; else the URL."""
        found = self._adapter is not None and self._adapter.exists()
        self._port_name = str(self._adapter) if found else self.url
        port = open_port(self._port_name, self._baud)
        self._adapter = persistent_name(self._port_name, self._adapters)
        return port

    def _go_up(self) -> None:
        with self._lock:
            self.trouble, self.reason = None, ""
            self._queue.clear()
            self._waiting = 0
            self._overflowed = False
            self.state = LinkState.UP
        self.counters.times_up += 1
        self._listener.link_up(self._clock())

    def _go_down(self, failure: PortError) -> None:
        reason = str(failure)
        with self._lock:
            if self.state is LinkState.UP:
                self.counters.times_lost += 1
            known = reason == self.reason
            self.state = LinkState.DOWN
            self.trouble, self.reason = failure.trouble, reason
        if failure.trouble is PortTrouble.STALLED:
            self.counters.overflows += 1
        if not known:
            self._listener.link_down(self._clock(), reason)

    def _serve(self, port: Port) -> None:
        """Move bytes both ways until ``close``; raise PortError once the port is lost."""
        poll = select.poll()
        poll.register(self._wake_reader, select.POLLIN)
        while not self._closing.is_set():
            if self._overflowed:
                raise PortError(
                    f"output stalled: {self.url} takes no more bytes", PortTrouble.STALLED
                )
            events = select.POLLIN | (select.POLLOUT if self._queue else 0)
            poll.register(port.fileno(), events)
            ready = dict(poll.poll())
            if self._wake_reader in ready:
                os.read(self._wake_reader, 4096)
            if ready.get(port.fileno(), 0) & ~select.POLLOUT:
                self._receive(port)
            if self._queue:
                self._send(port)

    def _receive(self, port: Port) -> None:
        data = port.read()
        if data:
            t = self._clock()
            self.counters.bytes_in += len(data)
            self._listener.received(t, data)

    def _send(self, port: Port) -> None:
        """Carry out queued requests until the port takes no more."""
        while self._queue:
            request = self._queue[0]
            if isinstance(request, _End):
                self._ended = True
                self._queue.popleft()
                continue
            if isinstance(request, SetBaud):
                port.set_baud(request.baud)
                self._queue.popleft()
                continue
            sent = port.write(request.data)
            self.counters.bytes_out += sent
            with self._lock:
                self._waiting -= sent
                if sent == len(request.data):
                    self._queue.popleft()
                else:
                    self._queue[0] = Write(request.data[sent:])
            if not sent:
                return

    def _finish_writes(self, port: Port) -> None:
        poll = select.poll()
        poll.register(port.fileno(), select.POLLOUT)
        give_up = time.monotonic() + CLOSING_LIMIT
        while self._queue and (left := give_up - time.monotonic()) > 0:
            poll.poll(1000 * left)
            self._send(port)
        if not self._queue:
            port.drain()
