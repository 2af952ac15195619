"""An open line to a device: a serial port or a TCP connection, as non-blocking reads and writes."""

from __future__ import annotations

import errno
import os
import socket
import termios
import time
from enum import StrEnum
from typing import Protocol
from urllib.parse import urlsplit

import serial

CONNECT_LIMIT = 1.0  # s
READ_SIZE = 4096
_SLOW_ENOUGH = 115200  # baud; above this a byte is over before its receiver is ready for the next
_BYTE_GAP = 60e-6  # s between bytes sent faster than that: a laser at 500000 baud asks for 55 us


class PortTrouble(StrEnum):
    """What keeps a port from being open."""

    MISSING = "missing"  # no such device: not plugged in, or under another name
    NO_PERMISSION = "no permission"
    IN_USE = "in use"  # by another process
    NO_DEVICE = "no device"  # a name with nothing behind it
    NOT_A_PORT = "not a port"
    BAD_ADDRESS = "bad address"
    REFUSED = "refused"  # the host is there, nothing listens
    UNREACHABLE = "unreachable"
    UNPLUGGED = "unplugged"  # was open, is gone
    HUNG_UP = "hung up"  # the other side closed the connection
    STALLED = "stalled"  # takes no more bytes
    BAD_RATE = "bad rate"
    OTHER = "other"


class PortError(OSError):
    """A port could not be opened, or was lost; the message says why and what to do, in one line."""

    def __init__(self, message: str, trouble: PortTrouble = PortTrouble.OTHER) -> None:
        super().__init__(message)
        self.trouble = trouble


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
        raise PortError(
            f"unknown kind of port {url}: use a device path or socket://host:port",
            PortTrouble.BAD_ADDRESS,
        )
    try:
        device = serial.Serial(url, baud, timeout=0, exclusive=True)
    except (OSError, ValueError) as failure:
        raise explain(url, failure) from failure
    return SerialPort(device)


def _open_socket(url: str) -> Port:
    try:
        parts = urlsplit(url)
        host, port = parts.hostname, parts.port
    except ValueError as failure:
        raise PortError(
            f"bad port number in {url}: use socket://host:port", PortTrouble.BAD_ADDRESS
        ) from failure
    if not host or not port:
        raise PortError(
            f"host or port number missing in {url}: use socket://host:port",
            PortTrouble.BAD_ADDRESS,
        )
    try:
        connection = socket.create_connection((host, port), CONNECT_LIMIT)
    except OSError as failure:
        raise explain(url, failure) from failure
    return SocketPort(connection)


_EXPLANATIONS = {
    PortTrouble.MISSING: (
        "no such port: {url}; check cable and name, 'patrol ports' lists what is there"
    ),
    PortTrouble.NO_PERMISSION: (
        "permission denied on {url}: add the user to group dialout and log in again"
    ),
    PortTrouble.IN_USE: "{url} is in use by another process: end that one first",
    PortTrouble.NO_DEVICE: "no device behind {url}: check that it is plugged in",
    PortTrouble.REFUSED: (
        "nothing listens at {url}: start the device server or correct the address"
    ),
    PortTrouble.UNREACHABLE: "cannot reach {url}: check the network and the address",
    PortTrouble.NOT_A_PORT: "{url} is not a serial port",
}
_TROUBLES = {
    errno.ENOENT: PortTrouble.MISSING,
    errno.EACCES: PortTrouble.NO_PERMISSION,
    errno.EPERM: PortTrouble.NO_PERMISSION,
    errno.EAGAIN: PortTrouble.IN_USE,
    errno.EBUSY: PortTrouble.IN_USE,
    errno.ENXIO: PortTrouble.NO_DEVICE,
    errno.ENODEV: PortTrouble.NO_DEVICE,
    errno.EIO: PortTrouble.NO_DEVICE,
    errno.ECONNREFUSED: PortTrouble.REFUSED,
    errno.EHOSTUNREACH: PortTrouble.UNREACHABLE,
    errno.ENETUNREACH: PortTrouble.UNREACHABLE,
    errno.ETIMEDOUT: PortTrouble.UNREACHABLE,
    errno.EISDIR: PortTrouble.NOT_A_PORT,
    errno.ENOTTY: PortTrouble.NOT_A_PORT,
}


def explain(url: str, failure: Exception) -> PortError:
    """Return the error that says in one line why ``url`` could not be opened and what to do."""
    trouble = _trouble_of(failure)
    if trouble is PortTrouble.OTHER:
        return PortError(f"cannot open {url}: {' '.join(str(failure).split())}")
    return PortError(_EXPLANATIONS[trouble].format(url=url), trouble)


def _trouble_of(failure: Exception) -> PortTrouble:
    if isinstance(failure, TimeoutError | socket.gaierror):
        return PortTrouble.UNREACHABLE
    number = _error_number(failure)
    return PortTrouble.OTHER if number is None else _TROUBLES.get(number, PortTrouble.OTHER)


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
        """Return the connection's descriptor."""
        return self._connection.fileno()

    def read(self) -> bytes:
        """Return what has arrived; PortError when the other side has closed."""
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
        """Send what the connection takes."""
        try:
            return self._connection.send(data)
        except BlockingIOError:
            return 0
        except OSError as failure:
            raise PortError(
                f"connection lost: {failure.strerror}", PortTrouble.HUNG_UP
            ) from failure

    def set_baud(self, baud: int) -> None:
        """Do nothing: the rate is the device server's affair."""

    def drain(self) -> None:
        """Do nothing: what was sent is on its way."""

    def close(self) -> None:
        """Close the connection."""
        self._connection.close()
