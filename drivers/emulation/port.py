"""Ports at which real clients reach an emulated device: a pseudo-terminal, or TCP.

Either can be unplugged and plugged in again like a cable; the device keeps running meanwhile.
"""

from __future__ import annotations

import math
import os
import select
import socket
import termios
import tty
from pathlib import Path
from typing import Protocol

from drivers.emulation.timed_bytes import TimedBytes

READ_SIZE = 4096
MAX_WAITING = 65536  # bytes a TCP client may leave unread before it is cut off
RATE_DOUBT = 0.1  # s after a client's change of rate in which bytes read may be older than it

_GARBLE_TABLE = bytes((167 * octet + 71) & 0xFF for octet in range(256))
_BAUD_BY_CODE = {
    getattr(termios, name): int(name[1:])
    for name in dir(termios)
    if name.startswith("B") and name[1:].isdigit()
}


def garbled(data: bytes) -> bytes:
    """Return what a receiver decodes from bytes sent at another rate than its own: other bytes."""
    return data.translate(_GARBLE_TABLE)


class EmulatedDevice(Protocol):
    """The device's side of a line: the interface of the emulators."""

    @property
    def baud(self) -> int:
        """The device's present rate."""

    def feed(self, data: bytes, t: float) -> None:
        """Take bytes from the client."""

    def pop_output(self, t: float) -> list[TimedBytes]:
        """Return what has left the wire by ``t``."""


class PtyPort:
    """Serves an emulator on a pseudo-terminal; clients open ``url``, one after another.

    A pty carries bytes at any rate; a line does not. So while the client's rate is not the
    device's, bytes arrive garbled both ways; but what a client wrote before it changed its rate may
    be read after it, so for RATE_DOUBT its bytes count as sent at either rate. Without a client
    output is lost. ``name`` is a symbolic link to make: a device name that stays the same over
    unplugging.
    """

    def __init__(self, emulator: EmulatedDevice, name: Path | None = None) -> None:
        self._emulator = emulator
        self._name = name
        self._master = -1
        self._client_baud: int | None = None
        self._former_baud: int | None = None
        self._doubt_until = -math.inf
        self.plug_in()

    @property
    def url(self) -> str:
        """The path to open; without a ``name`` a new one after each ``plug_in``."""
        return self._device if self._name is None else str(self._name)

    def plug_in(self) -> None:
        """Make the port appear; no effect if it is there already."""
        if self._master >= 0:
            return
        self._master, slave = os.openpty()
        tty.setraw(slave)
        os.set_blocking(self._master, False)
        self._device = os.ttyname(slave)
        os.close(slave)  # from now on a hang-up means that no client is there
        self._client_there = False
        self._poll = select.poll()
        self._poll.register(self._master, select.POLLIN)
        if self._name is not None:
            self._name.symlink_to(self._device)

    def unplug(self) -> None:
        """Remove the port and disconnect its client."""
        if self._master < 0:
            return
        os.close(self._master)
        self._master = -1
        self._client_there = False
        if self._name is not None:
            self._name.unlink()

    def pump(self, t: float) -> None:
        """Move bytes both ways at ``t``, without waiting."""
        has_sent = self._poll_client()
        self._watch_rate(t)
        if has_sent:
            data = os.read(self._master, READ_SIZE)
            self._emulator.feed(data if self._may_be_understood(t) else garbled(data), t)
        while True:
            baud = self._emulator.baud
            output = self._emulator.pop_output(t)
            if not output:
                return
            data = b"".join(item.data for item in output)
            if self._client_there:
                self._write(data if self._client_baud == baud else garbled(data))

    def close(self) -> None:
        """Remove the port."""
        self.unplug()

    def _poll_client(self) -> bool:
        """Update whether a client is connected; return whether it has sent bytes."""
        if self._master < 0:
            return False
        events = dict(self._poll.poll(0)).get(self._master, 0)
        client_there = not events & select.POLLHUP
        if self._client_there and not client_there:
            self._discard_unread()
        if client_there and not self._client_there:
            self._client_baud = None  # what it opens with is no change
        self._client_there = client_there
        return bool(events & select.POLLIN)

    def _discard_unread(self) -> None:
        """Discard what a disconnected client did not read, so that the next one does not get it."""
        slave = os.open(self._device, os.O_RDWR | os.O_NOCTTY)
        termios.tcflush(slave, termios.TCIFLUSH)
        os.close(slave)

    def _watch_rate(self, t: float) -> None:
        """Notice a change of the client's rate, of which a pty tells nothing."""
        if self._master < 0:
            return
        baud = _BAUD_BY_CODE.get(termios.tcgetattr(self._master)[5])
        if baud != self._client_baud and self._client_baud is not None:
            self._former_baud, self._doubt_until = self._client_baud, t + RATE_DOUBT
        self._client_baud = baud

    def _may_be_understood(self, t: float) -> bool:
        """Whether what is read at ``t`` may have been sent at the device's rate."""
        possible = (self._client_baud, self._former_baud if t < self._doubt_until else None)
        return self._emulator.baud in possible

    def _write(self, data: bytes) -> None:
        try:
            os.write(self._master, data)  # a full buffer loses the rest, as an overrun does
        except BlockingIOError:
            return


class TcpPort:
    """Serves an emulator on a TCP port of this machine, to one client at a time; TCP has no rate.

    ``port`` 0 takes any free one. A second client is disconnected while the first is connected.
    """

    def __init__(self, emulator: EmulatedDevice, port: int = 0, host: str = "127.0.0.1") -> None:
        self._emulator = emulator
        self._client: socket.socket | None = None
        self._unsent = bytearray()
        self._listener = _listen(host, port)
        self._address = self._listener.getsockname()
        self.url = f"socket://{host}:{self._address[1]}"

    def plug_in(self) -> None:
        """Listen again; no effect if it listens already."""
        if self._listener.fileno() < 0:
            self._listener = _listen(*self._address[:2])

    def unplug(self) -> None:
        """Disconnect the client and stop listening."""
        self.hang_up()
        self._listener.close()

    def pump(self, t: float) -> None:
        """Move bytes both ways at ``t``, without waiting."""
        self._accept()
        data = self._receive()
        if data:
            self._emulator.feed(data, t)
        while output := self._emulator.pop_output(t):
            if self._client is not None:
                self._unsent += b"".join(item.data for item in output)
        self._flush()

    def close(self) -> None:
        """Disconnect the client and stop listening."""
        self.unplug()

    def _accept(self) -> None:
        if self._listener.fileno() < 0:
            return
        try:
            client, _address = self._listener.accept()
        except BlockingIOError:
            return
        if self._client is not None:
            client.close()
            return
        client.setblocking(False)
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._client = client

    def _receive(self) -> bytes:
        if self._client is None:
            return b""
        try:
            data = self._client.recv(READ_SIZE)
        except BlockingIOError:
            return b""
        except OSError:
            data = b""
        if not data:
            self.hang_up()
        return data

    def _flush(self) -> None:
        if self._client is None or not self._unsent:
            return
        try:
            sent = self._client.send(self._unsent)
        except BlockingIOError:
            sent = 0
        except OSError:
            self.hang_up()
            return
        del self._unsent[:sent]
        if len(self._unsent) > MAX_WAITING:
            self.hang_up()

    def hang_up(self) -> None:
        """Disconnect the client, if there is one."""
        if self._client is not None:
            self._client.close()
            self._client = None
        self._unsent.clear()


def _listen(host: str, port: int) -> socket.socket:
    listener = socket.create_server((host, port))
    listener.setblocking(False)
    return listener
