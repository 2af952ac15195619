"""Adapter that gives a pyserial port without a file descriptor one, by two threads and sockets."""

from __future__ import annotations

import contextlib
import socket
import threading
import time
from collections.abc import Callable
from typing import Protocol

import serial

from drivers.port_error import PortError, PortTrouble

READ_TIMEOUT = 0.1  # s; a closed port is noticed this late
_CHUNK = 4096
_FULL_PAUSE = 0.01  # s before a retry when the socket is full
_WRITE_LIMIT = 1.0  # s for written bytes to leave
_TROUBLES = (OSError, ValueError, AttributeError, TypeError)
"""Exceptions of pyserial; the last two come from a port closed during a blocking call."""


class Device(Protocol):
    """The common interface of pyserial's ports; opened with ``READ_TIMEOUT`` as its timeout."""

    baudrate: int

    @property
    def in_waiting(self) -> int:
        """Bytes that have arrived."""

    def read(self, size: int, /) -> bytes:
        """Return ``size`` bytes, fewer after the timeout."""

    def write(self, data: bytes, /) -> int | None:
        """Send bytes; blocks until they are taken."""

    def flush(self) -> None:
        """Wait until all written bytes have left."""

    def reset_input_buffer(self) -> None:
        """Discard unread bytes."""

    def close(self) -> None:
        """Close the port."""


class PumpedPort:
    """``rfc2217://``, ``loop://``, ``spy://`` or another URL of pyserial, as a ``Port``.

    One thread reads the port, one writes it; between them and the caller is a pair of sockets.
    """

    def __init__(self, url: str, device: Device) -> None:
        self._url = url
        self._device = device
        if isinstance(device, serial.Serial):
            device.write_timeout = _WRITE_LIMIT
        self._near, self._far = socket.socketpair()
        self._near.setblocking(False)
        self._changed = threading.Condition()
        self._to_write = 0  # bytes taken from the caller and not by the port
        self._wanted_baud: int | None = None  # the reading thread sets it, so no byte is misread
        self._refusal = ""  # why the last change of rate failed, "" if it did not
        self._failure = ""
        self._closing = False
        self._threads = [
            threading.Thread(target=self._run, args=(work,), name=f"{name} {url}", daemon=True)
            for name, work in (("read", self._read_on), ("write", self._write_on))
        ]
        for thread in self._threads:
            thread.start()

    def fileno(self) -> int:
        """Return the file descriptor of this end of the socket pair."""
        return self._near.fileno()

    def read(self) -> bytes:
        """Return the bytes that have arrived; PortError once the port has failed."""
        try:
            data = self._near.recv(_CHUNK)
        except BlockingIOError:
            return b""
        if not data:
            raise self._lost()
        return data

    def write(self, data: bytes) -> int:
        """Send what the socket pair takes and return its length."""
        with self._changed:
            try:
                sent = self._near.send(data)
            except BlockingIOError:
                return 0
            except OSError as failure:
                raise self._lost() from failure
            self._to_write += sent
        return sent

    def set_baud(self, baud: int) -> None:
        """Let all written bytes leave, change the rate, discard unread input."""
        self.drain()
        with self._changed:
            self._wanted_baud, self._refusal = baud, ""
            self._changed.wait_for(lambda: self._wanted_baud is None or self._failure)
            if self._failure:
                raise self._lost()
            if self._refusal:
                raise PortError(
                    f"port cannot run at {baud} baud: {self._refusal}", PortTrouble.BAD_RATE
                )

    def drain(self) -> None:
        """Wait until the port has taken all written bytes; PortError after 1 s."""
        with self._changed:
            self._changed.wait_for(lambda: self._failure or not self._to_write, _WRITE_LIMIT)
            if self._failure:
                raise self._lost()
            if self._to_write:
                raise PortError(
                    f"output stalled: {self._url} takes no more bytes", PortTrouble.STALLED
                )
        try:
            self._device.flush()
        except _TROUBLES as failure:
            raise self._lost() from failure

    def close(self) -> None:
        """End the threads and close the port."""
        self._closing = True
        self._near.close()
        for thread in self._threads:
            thread.join(_WRITE_LIMIT)
        self._device.close()
        for thread in self._threads:  # a blocking network call ended only now
            thread.join(_WRITE_LIMIT)
        self._far.close()

    def _lost(self) -> PortError:
        reason = self._failure or "closed"
        return PortError(
            f"{self._url} is lost: {reason}; check cable, device server and network",
            PortTrouble.HUNG_UP,
        )

    # The threads

    def _run(self, work: Callable[[], None]) -> None:
        failure = "closed"
        try:
            work()
        except _TROUBLES as trouble:
            failure = _one_line(trouble)
        finally:
            with self._changed:
                self._failure = self._failure or failure
                self._changed.notify_all()
            with contextlib.suppress(OSError):  # closed meanwhile
                self._far.shutdown(socket.SHUT_RDWR)

    def _read_on(self) -> None:
        while not self._closing:
            if self._wanted_baud is not None:
                self._change_rate(self._wanted_baud)
            data = self._device.read(1)
            data += self._device.read(min(self._device.in_waiting, _CHUNK)) if data else b""
            while data and not self._closing and self._wanted_baud is None:
                data = data[self._offer(data) :]

    def _offer(self, data: bytes) -> int:
        try:
            return self._far.send(data, socket.MSG_DONTWAIT)
        except BlockingIOError:
            time.sleep(_FULL_PAUSE)
            return 0

    def _change_rate(self, baud: int) -> None:
        try:
            self._device.baudrate = baud
            self._device.reset_input_buffer()
            refusal = ""
        except _TROUBLES as failure:
            refusal = _one_line(failure)
        with self._changed, contextlib.suppress(BlockingIOError):
            self._wanted_baud, self._refusal = None, refusal
            self._changed.notify_all()
            while self._near.recv(_CHUNK):
                pass

    def _write_on(self) -> None:
        while data := self._far.recv(_CHUNK):
            self._device.write(data)
            with self._changed:
                self._to_write -= len(data)
                self._changed.notify_all()


def _one_line(failure: Exception) -> str:
    return " ".join(str(failure).split())
