"""Ports at which real clients reach an emulated device: a pseudo-terminal, or TCP.

Either can be unplugged and plugged in again, as a cable; the device lives on meanwhile.
"""

from __future__ import annotations

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

_GARBLE_TABLE = bytes((167 * octet + 71) & 0xFF for octet in range(256))
_BAUD_BY_CODE = {
    getattr(termios, name): int(name[1:])
    for name in dir(termios)
    if name.startswith("B") and name[1:].isdigit()
}


def garbled(data: bytes) -> bytes:
    """Return what a receiver makes of bytes sent at another rate than its own: other bytes."""
    return data.translate(_GARBLE_TABLE)


class EmulatedDevice(Protocol):
    """The device's side of a line, as the emulators provide it."""

    @property
    def baud(self) -> int:
        """The device's present rate."""

    def feed(self, data: bytes, t: float) -> None:
        """Take bytes from the client."""

    def pop_output(self, t: float) -> list[TimedBytes]:
        """Return what has left the wire by ``t``."""


class PtyPort:
    """Hosts an emulator on a pseudo-terminal; ``url`` is the path clients open, again and again.

    A pty carries bytes at any rate; a line does not. So while the client's rate is not the
    device's, what either sends arrives as other bytes. With nobody there output is lost. ``name``
    is a link to make and keep: a device name that outlives unplugging.
    """

    def __init__(self, emulator: EmulatedDevice, name: Path | None = None) -> None:
        self._emulator = emulator
        self._name = name
        self._master = -1
        self.plug_in()

    @property
    def url(self) -> str:
        """The path to open; without a ``name`` a new one after each plugging in."""
        return self._device if self._name is None else str(self._name)

    def plug_in(self) -> None:
        """Make the port appear; nothing where it is there already."""
        if self._master >= 0:
            return
        self._master, slave = os.openpty()
        tty.setraw(slave)
        os.set_blocking(self._master, False)
        self._device = os.ttyname(slave)
        os.close(slave)  # from now on a hang-up tells that no client is there
        self._client_there = False
        self._poll = select.poll()
        self._poll.register(self._master, select.POLLIN)
        if self._name is not None:
            self._name.symlink_to(self._device)

    def unplug(self) -> None:
        """Take the port away; its client is hung up on."""
        if self._master < 0:
            return
        os.close(self._master)
        self._master = -1
        self._client_there = False
        if self._name is not None:
            self._name.unlink()

    def pump(self, t: float) -> None:
        """Carry bytes both ways at time ``t`` (s), without waiting."""
        if self._look_for_client():
            data = os.read(self._master, READ_SIZE)
            self._emulator.feed(self._as_received(data, self._emulator.baud), t)
        while True:
            baud = self._emulator.baud
            output = self._emulator.pop_output(t)
            if not output:
                return
            data = b"".join(item.data for item in output)
            if self._client_there:
                self._write(self._as_received(data, baud))

    def close(self) -> None:
        """Take the port away for good."""
        self.unplug()

    def _look_for_client(self) -> bool:
        """Notice a client coming or going; return whether bytes from it are waiting."""
        if self._master < 0:
            return False
        events = dict(self._poll.poll(0)).get(self._master, 0)
        client_there = not events & select.POLLHUP
        if self._client_there and not client_there:
            self._discard_unread()
        self._client_there = client_there
        return bool(events & select.POLLIN)

    def _discard_unread(self) -> None:
        """Drop what a client that left did not read: the next one shall not find it."""
        slave = os.open(self._device, os.O_RDWR | os.O_NOCTTY)
        termios.tcflush(slave, termios.TCIFLUSH)
        os.close(slave)

    def _as_received(self, data: bytes, device_baud: int) -> bytes:
        client_baud = _BAUD_BY_CODE.get(termios.tcgetattr(self._master)[5])
        return data if client_baud == device_baud else garbled(data)

    def _write(self, data: bytes) -> None:
        try:
            os.write(self._master, data)  # what a full buffer refuses is lost, as by an overrun
        except BlockingIOError:
            return


class TcpPort:
    """Hosts an emulator on a TCP port of this machine, for one client at a time; TCP has no rate.

    ``port`` 0 takes any free one. A client may leave and another come; a second one meanwhile is
    hung up on.
    """

    def __init__(self, emulator: EmulatedDevice, port: int = 0, host: str = "127.0.0.1") -> None:
        self._emulator = emulator
        self._client: socket.socket | None = None
        self._unsent = bytearray()
        self._listener = _listen(host, port)
        self._address = self._listener.getsockname()
        self.url = f"socket://{host}:{self._address[1]}"

    def plug_in(self) -> None:
        """Listen again; nothing where it listens already."""
        if self._listener.fileno() < 0:
            self._listener = _listen(*self._address[:2])

    def unplug(self) -> None:
        """Hang up and stop listening."""
        self._hang_up()
        self._listener.close()

    def pump(self, t: float) -> None:
        """Carry bytes both ways at time ``t`` (s), without waiting."""
        self._accept()
        data = self._receive()
        if data:
            self._emulator.feed(data, t)
        while output := self._emulator.pop_output(t):
            if self._client is not None:
                self._unsent += b"".join(item.data for item in output)
        self._flush()

    def close(self) -> None:
        """Hang up and stop listening for good."""
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
            self._hang_up()
        return data

    def _flush(self) -> None:
        if self._client is None or not self._unsent:
            return
        try:
            sent = self._client.send(self._unsent)
        except BlockingIOError:
            sent = 0
        except OSError:
            self._hang_up()
            return
        del self._unsent[:sent]
        if len(self._unsent) > MAX_WAITING:
            self._hang_up()

    def _hang_up(self) -> None:
        if self._client is not None:
            self._client.close()
            self._client = None
        self._unsent.clear()


def _listen(host: str, port: int) -> socket.socket:
    listener = socket.create_server((host, port))
    listener.setblocking(False)
    return listener
