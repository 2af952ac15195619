"""An open line to a device: a serial port, a TCP connection or any other URL that pyserial knows.

All reads and writes are non-blocking.
"""

from __future__ import annotations

import os
import re
import socket
import termios
import time
from typing import Protocol
from urllib.parse import urlsplit

import serial

from drivers.port_error import PortError, PortTrouble, explain
from drivers.pumped_port import READ_TIMEOUT, PumpedPort

CONNECT_LIMIT = 1.0  # s
READ_SIZE = 4096
_NETWORK = ("socket", "rfc2217")
_SLOW_ENOUGH = 115200  # baud; above this the receiver needs a gap between bytes
_BYTE_GAP = 60e-6  # s between bytes sent faster than that: a laser at 500000 baud asks for 55 us


class Port(Protocol):
    """An open line. Every method but ``close`` raises PortError once the line is lost."""

    def fileno(self) -> int:
        """Return the file descriptor to wait on."""

    def read(self) -> bytes:
        """Return what has arrived, without waiting; call when the descriptor is readable."""

    def write(self, data: bytes) -> int:
        """Send as much as the line takes now; return how many bytes that was."""

    def set_baud(self, baud: int) -> None:
        """Let all written bytes leave, change the rate, discard unread input."""

    def drain(self) -> None:
        """Wait until all written bytes have left."""

    def close(self) -> None:
        """Close the line; may be called once."""


def open_port(url: str, baud: int) -> Port:
    """Open a serial device, a pty's path, or a URL of pyserial, exclusively.

    ``socket://host:port`` is a device server without, ``rfc2217://host:port`` one with control of
    the rate. Raises PortError naming the port, the reason and the remedy.
    """
    scheme = url.partition("://")[0].lower() if "://" in url else ""
    if scheme in _NETWORK:
        host, port = _address(url, scheme)
        if scheme == "socket":
            return _connect(url, host, port)
    try:
        device = serial.serial_for_url(url, baud, timeout=READ_TIMEOUT, exclusive=True)
    except (OSError, ValueError, LookupError, re.error) as failure:  # of an option, a pattern
        raise explain(url, failure) from failure
    if isinstance(device, serial.Serial) and scheme != "spy":
        return SerialPort(device)
    return PumpedPort(url, device)


def _address(url: str, scheme: str) -> tuple[str, int]:
    try:
        parts = urlsplit(url)
        host, port = parts.hostname, parts.port
    except ValueError as failure:
        raise PortError(
            f"bad port number in {url}: use {scheme}://host:port", PortTrouble.BAD_ADDRESS
        ) from failure
    if not host or not port:
        raise PortError(
            f"host or port number missing in {url}: use {scheme}://host:port",
            PortTrouble.BAD_ADDRESS,
        )
    return host, port


def _connect(url: str, host: str, port: int) -> Port:
    try:
        connection = socket.create_connection((host, port), CONNECT_LIMIT)
    except OSError as failure:
        raise explain(url, failure) from failure
    return SocketPort(connection)


class SerialPort:
    """A serial device or pty, opened by pyserial."""

    def __init__(self, device: serial.Serial) -> None:
        self._device = device
        self._fd: int = device.fileno()

    def fileno(self) -> int:
        """Return the device's file descriptor."""
        return self._fd

    def read(self) -> bytes:
        """Return the bytes that have arrived; PortError if readable without bytes: unplugged."""
        try:
            data = os.read(self._fd, READ_SIZE)
        except BlockingIOError:
            return b""
        except OSError as failure:
            raise self._gone() from failure
        if not data:
            raise self._gone()
        return data

    def write(self, data: bytes) -> int:
        """Send what the kernel's buffer takes and return its length; one byte above 115200 baud."""
        if self._device.baudrate > _SLOW_ENOUGH:
            data = data[:1]
            time.sleep(_BYTE_GAP)
        try:
            return os.write(self._fd, data)
        except BlockingIOError:
            return 0
        except OSError as failure:
            raise self._gone() from failure

    def set_baud(self, baud: int) -> None:
        """Let all written bytes leave, change the rate, discard unread input."""
        self.drain()
        try:
            self._device.baudrate = baud
            self._device.reset_input_buffer()
        except (OSError, ValueError, termios.error) as failure:
            raise PortError(
                f"port cannot run at {baud} baud: {failure}", PortTrouble.BAD_RATE
            ) from failure

    def drain(self) -> None:
        """Wait until all written bytes have left."""
        try:
            self._device.flush()
        except (OSError, termios.error) as failure:
            raise self._gone() from failure

    def close(self) -> None:
        """Close the device."""
        self._device.close()

    def _gone(self) -> PortError:
        return PortError(
            f"device is gone: was {self._device.port} unplugged?", PortTrouble.UNPLUGGED
        )


class SocketPort:
    """A TCP connection to a serial device server or an emulated device; it has no rate."""

    def __init__(self, connection: socket.socket) -> None:
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connection.setblocking(False)
        self._connection = connection

    def fileno(self) -> int:
        """Return the connection's file descriptor."""
        return self._connection.fileno()

    def read(self) -> bytes:
        """Return the bytes that have arrived; PortError when the other side has closed."""
        try:
            data = self._connection.recv(READ_SIZE)
        except BlockingIOError:
            return b""
        except OSError as failure:
            raise PortError(
                f"connection lost: {failure.strerror}", PortTrouble.HUNG_UP
            ) from failure
        if not data:
            raise PortError("connection closed by the other side", PortTrouble.HUNG_UP)
        return data

    def write(self, data: bytes) -> int:
        """Send what the connection takes and return its length."""
        try:
            return self._connection.send(data)
        except BlockingIOError:
            return 0
        except OSError as failure:
            raise PortError(
                f"connection lost: {failure.strerror}", PortTrouble.HUNG_UP
            ) from failure

    def set_baud(self, baud: int) -> None:
        """Do nothing: the rate is set at the device server."""

    def drain(self) -> None:
        """Do nothing: TCP does not report when bytes have left."""

    def close(self) -> None:
        """Close the connection."""
        self._connection.close()
