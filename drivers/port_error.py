"""Errors of opening or losing a port, each explained in one line with a remedy."""

from __future__ import annotations

import errno
import socket
import termios
from enum import StrEnum


class PortTrouble(StrEnum):
    """Why a port is not open."""

    MISSING = "missing"  # no such device node: not plugged in, or renamed
    NO_PERMISSION = "no permission"
    FILTERED = "filtered"  # by the service's device filter, whatever the file's rights
    IN_USE = "in use"  # by another process
    NO_DEVICE = "no device"  # a device node without a device
    NOT_A_PORT = "not a port"
    BAD_ADDRESS = "bad address"
    REFUSED = "refused"  # the host answers, nothing listens at the port
    UNREACHABLE = "unreachable"
    UNPLUGGED = "unplugged"  # was open, is gone
    HUNG_UP = "hung up"  # the other side closed the connection
    STALLED = "stalled"  # takes no more bytes
    BAD_RATE = "bad rate"
    OTHER = "other"


class PortError(OSError):
    """A port could not be opened or was lost; the message is one line with reason and remedy."""

    def __init__(self, message: str, trouble: PortTrouble = PortTrouble.OTHER) -> None:
        super().__init__(message)
        self.trouble = trouble


_EXPLANATIONS = {
    PortTrouble.MISSING: (
        "no such port: {url}; check cable and name, 'patrol ports' lists what is there"
    ),
    PortTrouble.NO_PERMISSION: (
        "permission denied on {url}: add the user to group dialout and log in again"
    ),
    PortTrouble.FILTERED: (
        "the service's device filter keeps {url} out: it was made before the driver of the device "
        "was loaded; start the service again, and list that driver in /etc/modules-load.d"
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
    errno.EPERM: PortTrouble.FILTERED,
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
    """Return the PortError for a failure to open ``url``, with reason and remedy in one line."""
    reason = " ".join(str(failure).split())
    if reason.startswith("invalid URL"):
        return PortError(
            f"unknown kind of port {url}: use a device path, socket://host:port or another URL "
            "that pyserial knows",
            PortTrouble.BAD_ADDRESS,
        )
    if reason.startswith("no ports found matching"):  # hwgrep://
        return PortError(_EXPLANATIONS[PortTrouble.MISSING].format(url=url), PortTrouble.MISSING)
    trouble = _trouble_of(failure)
    if trouble is PortTrouble.OTHER:
        return PortError(f"cannot open {url}: {reason}")
    return PortError(_EXPLANATIONS[trouble].format(url=url), trouble)


def _trouble_of(failure: BaseException) -> PortTrouble:
    if isinstance(failure, TimeoutError | socket.gaierror):
        return PortTrouble.UNREACHABLE
    number = failure.errno if isinstance(failure, OSError) else None
    cause = failure.__context__
    if isinstance(cause, termios.error):
        number = cause.args[0]
    elif number is None and isinstance(cause, OSError):
        return _trouble_of(cause)  # pyserial drops the errno of network errors
    return PortTrouble.OTHER if number is None else _TROUBLES.get(number, PortTrouble.OTHER)
