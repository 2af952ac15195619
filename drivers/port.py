"""An open line to a device: a serial port or a TCP connection, as non-blocking reads and writes."""

from __future__ import annotations

import errno
import os
import socket
import termios
import time
from typing import Protocol
from urllib.parse import urlsplit

import serial

CONNECT_LIMIT = 2.0  # s
READ_SIZE = 4096
_SLOW_ENOUGH = 115200  # baud; above this a byte is over before its receiver is ready for the next
_BYTE_GAP = 60e-6  # s between bytes sent faster than that: a laser at 500000 baud asks for 55 us


class PortError(OSError):
    """A port could not be opened, or was lost; the message says why and what to do, in one line."""


class Port(Protocol):
    """An open line. Every method but ``close`` raises PortError once the line is lost."""

    def fileno(self) -> int:
        """Return the descriptor to wait on."""

    def read(self) -> bytes:
        """Return what has arrived, without waiting; call when the descriptor is readable."""

    def write(self, data: bytes) -> int:
        """Send as much as the line takes now; return how many bytes that was."""

    def set_baud(self, baud: int) -> None:
        """Let all written bytes leave, change the rate, discard unread input."""

    def drain(self) -> None:
        """Wait until all written bytes have left."""

    def close(self) -> None:
        """Give the line back; may be called once."""


def open_port(url: str, baud: int) -> Port:
    """Open a serial device, a pty's path, or ``socket://host:port``, for this process alone.

    Raises PortError naming the port, the reason and the remedy.
    """
    parts = urlsplit(url)
    if parts.scheme == "socket":
        return _open_socket(url)
    if "://" in url:
        raise PortError(f"unknown kind of port {url}: use a device path or socket://host:port")
    try:
        device = serial.Serial(url, baud, timeout=0, exclusive=True)
    except (OSError, ValueError) as failure:
        raise PortError(explain(url, failure)) from failure
    return SerialPort(device)


def _open_socket(url: str) -> Port:
    try:
        parts = urlsplit(url)
        host, port = parts.hostname, parts.port
    except ValueError as failure:
        raise PortError(f"bad port number in {url}: use socket://host:port") from failure
    if not host or not port:
        raise PortError(f"host or port number missing in {url}: use socket://host:port")
    try:
        connection = socket.create_connection((host, port), CONNECT_LIMIT)
    except OSError as failure:
        raise PortError(explain(url, failure)) from failure
    return SocketPort(connection)


def explain(url: str, failure: Exception) -> str:
    """Say in one line why ``url`` could not be opened and what to do about it."""
    match _error_number(failure):
        case errno.ENOENT:
            return f"no such port: {url}; check cable and name, 'patrol ports' lists what is there"
        case errno.EACCES | errno.EPERM:
            return f"permission denied on {url}: add the user to group dialout and log in again"
        case errno.EAGAIN | errno.EBUSY:
            return f"{url} is in use by another process: end that one first"
        case errno.ENXIO | errno.ENODEV | errno.EIO:
            return f"no device behind {url}: check that it is plugged in"
        case errno.ECONNREFUSED:
            return f"nothing listens at {url}: start the device server or correct the address"
        case errno.EISDIR | errno.ENOTTY:
            return f"{url} is not a serial port"
    return f"cannot open {url}: {' '.join(str(failure).split())}"


def _error_number(failure: Exception) -> int | None:
    """Return the errno of a failure; pyserial passes on termios errors without theirs."""
    if isinstance(failure.__context__, termios.error):
        number: int = failure.__context__.args[0]
        return number
    return failure.errno if isinstance(failure, OSError) else None


class SerialPort:
    """A serial device or pty, opened by pyserial."""

    def __init__(self, device: serial.Serial) -> None:
        self._device = device
        self._fd: int = device.fileno()

    def fileno(self) -> int:
        """Return the device's descriptor."""
        return self._fd

    def read(self) -> bytes:
        """Return what has arrived; a readable device without bytes has gone."""
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
        """Send what the driver's buffer takes; byte by byte above 115200 baud."""
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
            raise PortError(f"port cannot run at {baud} baud: {failure}") from failure

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
        return PortError(f"device is gone: was {self._device.port} unplugged?")


class SocketPort:
    """A TCP connection to a serial device server or an emulated device; it has no rate."""

    def __init__(self, connection: socket.socket) -> None:
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connection.setblocking(False)
        self._connection = connection

    def fileno(self) -> int:
        """Return the connection's descriptor."""
        return self._connection.fileno()

    def read(self) -> bytes:
        """Return what has arrived; PortError when the other side has closed."""
        try:
            data = self._connection.recv(READ_SIZE)
        except BlockingIOError:
            return b""
        except OSError as failure:
            raise PortError(f"connection lost: {failure.strerror}") from failure
        if not data:
            raise PortError("connection closed by the other side")
        return data

    def write(self, data: bytes) -> int:
        """Send what the connection takes."""
        try:
            return self._connection.send(data)
        except BlockingIOError:
            return 0
        except OSError as failure:
            raise PortError(f"connection lost: {failure.strerror}") from failure

    def set_baud(self, baud: int) -> None:
        """Do nothing: the rate is the device server's affair."""

    def drain(self) -> None:
        """Do nothing: what was sent is on its way."""

    def close(self) -> None:
        """Close the connection."""
        self._connection.close()
