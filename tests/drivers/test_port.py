"""Opening a port: every error names port, reason and remedy in one line."""

from __future__ import annotations

import errno
import os
import socket
from pathlib import Path

import pytest

from drivers.port import open_port
from drivers.port_error import PortError, explain


@pytest.mark.parametrize(
    ("number", "says"),
    [
        (errno.ENOENT, "no such port"),
        (errno.EACCES, "group dialout"),
        (errno.EPERM, "device filter keeps"),
        (errno.EAGAIN, "in use by another process"),
        (errno.EBUSY, "in use by another process"),
        (errno.EIO, "plugged in"),
        (errno.ENXIO, "plugged in"),
        (errno.ECONNREFUSED, "nothing listens"),
        (errno.EHOSTUNREACH, "cannot reach"),
        (errno.ENOSPC, "cannot open /dev/ttyS2"),
    ],
)
def test_failures_have_reason_and_remedy(number: int, says: str) -> None:
    text = str(explain("/dev/ttyS2", OSError(number, os.strerror(number))))
    assert says in text
    assert "/dev/ttyS2" in text
    assert "\n" not in text


@pytest.mark.parametrize(
    ("url", "says"),
    [
        ("/dev/no-such-port", "no such port: /dev/no-such-port"),
        ("/dev/null", "not a serial port"),
        ("/", "not a serial port"),
        ("gopher://host:1", "unknown kind of port"),
        ("rfc2217://127.0.0.1", "port number missing"),
        ("socket://[::1", "bad port number"),
        ("socket://127.0.0.1", "port number missing"),
        ("socket://127.0.0.1:99999", "bad port number"),
        ("socket://:4000", "host or port number missing"),
    ],
)
def test_invalid_ports_are_refused(url: str, says: str) -> None:
    with pytest.raises(PortError, match=says):
        open_port(url, 9600)


def test_plain_file_is_no_port(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("text")
    with pytest.raises(PortError, match="not a serial port"):
        open_port(str(file), 9600)


def test_port_without_a_listener_is_refused() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        number = server.getsockname()[1]
    with pytest.raises(PortError, match="nothing listens"):
        open_port(f"socket://127.0.0.1:{number}", 9600)


def test_unsupported_rate_is_refused() -> None:
    master, slave = os.openpty()
    port = open_port(os.ttyname(slave), 9600)
    try:
        with pytest.raises(PortError, match="-1 baud"):
            port.set_baud(-1)
    finally:
        port.close()
        os.close(master)
        os.close(slave)
