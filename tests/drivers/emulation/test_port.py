"""Ports of emulated devices, pumped by hand at chosen times; the clients are plain descriptors."""

from __future__ import annotations

import select
import socket
import termios
from collections.abc import Iterator
from contextlib import closing

import pytest
import serial

from drivers.emulation.port import RATE_DOUBT, PtyPort, TcpPort
from drivers.emulation.timed_bytes import TimedBytes
from drivers.lms200.emulator.emulator import Lms200Emulator
from drivers.lms200.framing import encode_telegram

READ_ERRORS = encode_telegram(b"\x32")
NO_ERRORS = b"\x06" + encode_telegram(b"\xb2\x10", 0x80)
TO_38400 = encode_telegram(b"\x20\x40")
MODE_OK = b"\x06" + encode_telegram(b"\xa0\x00\x10", 0x80)


@pytest.fixture
def pty_port() -> Iterator[PtyPort]:
    port = PtyPort(Lms200Emulator())
    yield port
    port.close()


@pytest.fixture
def tcp_port() -> Iterator[TcpPort]:
    port = TcpPort(Lms200Emulator())
    yield port
    port.close()


def connect(port: TcpPort) -> socket.socket:
    host, number = port.url.removeprefix("socket://").split(":")
    client = socket.create_connection((host, int(number)), timeout=5.0)
    port.pump(0.0)
    return client


def readable(descriptor: int, limit: float = 5.0) -> bool:
    return bool(select.select([descriptor], [], [], limit)[0])


def test_pty_answers_when_the_reply_has_left_the_wire(pty_port: PtyPort) -> None:
    with serial.Serial(pty_port.url, 9600, timeout=0) as client:
        client.write(READ_ERRORS)
        pty_port.pump(1.0)
        assert client.read(100) == b""
        pty_port.pump(1.002)
        assert client.read(100) == b"\x06"
        pty_port.pump(1.1)
        assert client.read(100) == NO_ERRORS[1:]


def test_pty_serves_successive_clients(pty_port: PtyPort) -> None:
    for t in (1.0, 3.0, 5.0):
        with serial.Serial(pty_port.url, 9600, timeout=0) as client:
            client.write(READ_ERRORS)
            pty_port.pump(t)
            pty_port.pump(t + 1.0)
            assert client.read(100) == NO_ERRORS
        pty_port.pump(t + 1.5)


def test_pty_passes_every_byte_value_unchanged() -> None:
    class Echo:
        baud = 9600

        def __init__(self) -> None:
            self.data = b""

        def feed(self, data: bytes, t: float) -> None:
            self.data += data

        def pop_output(self, t: float) -> list[TimedBytes]:
            data, self.data = self.data, b""
            return [TimedBytes(t, data)] if data else []

    every = bytes(range(256))
    with closing(PtyPort(Echo())) as port, serial.Serial(port.url, 9600, timeout=0) as client:
        client.write(every)
        port.pump(0.0)
        assert client.read(1000) == every
        client.baudrate = 19200
        client.write(every)
        port.pump(1.0)
        spoilt_twice = client.read(1000)
        assert len(spoilt_twice) == 256
        assert sum(a == b for a, b in zip(spoilt_twice, every, strict=True)) < 8


def test_pty_output_without_a_client_is_lost(pty_port: PtyPort) -> None:
    with serial.Serial(pty_port.url, 9600, timeout=0) as client:
        client.write(READ_ERRORS)
        pty_port.pump(1.0)
        pty_port.pump(1.002)  # the ACK stays unread
    pty_port.pump(2.0)
    slave = open(pty_port.url, "rb", buffering=0)  # noqa: SIM115, PTH123 - a client that flushes nothing
    with slave:
        assert not readable(slave.fileno(), 0.0)


def test_pty_understands_what_was_written_before_a_change_of_rate_and_read_after_it(
    pty_port: PtyPort,
) -> None:
    with serial.Serial(pty_port.url, 9600, timeout=0) as client:
        pty_port.pump(1.0)
        client.write(TO_38400)
        client.baudrate = 38400  # before the busy machine comes to read
        pty_port.pump(2.0)
        pty_port.pump(2.05)
        client.write(READ_ERRORS)
        pty_port.pump(3.0)
        pty_port.pump(4.0)
        assert client.read(100).endswith(NO_ERRORS)


def test_pty_garbles_what_is_read_later_than_a_change_of_rate_allows(pty_port: PtyPort) -> None:
    with serial.Serial(pty_port.url, 9600, timeout=0) as client:
        pty_port.pump(1.0)
        client.baudrate = 38400
        pty_port.pump(2.0)
        client.write(READ_ERRORS)
        pty_port.pump(2.0 + RATE_DOUBT)
        pty_port.pump(3.0)
        client.baudrate = 9600
        pty_port.pump(4.0)
        assert client.read(100) == b""


def test_pty_garbles_while_the_rates_differ(pty_port: PtyPort) -> None:
    with serial.Serial(pty_port.url, 38400, timeout=0) as client:
        client.write(READ_ERRORS)
        pty_port.pump(1.0)
        pty_port.pump(2.0)
        assert NO_ERRORS[1:] not in client.read(100)
        client.baudrate = 9600
        client.write(READ_ERRORS)
        pty_port.pump(3.0)
        pty_port.pump(4.0)
        assert client.read(100) == NO_ERRORS


def test_pty_reply_to_a_rate_change_is_read_at_the_old_rate(pty_port: PtyPort) -> None:
    with serial.Serial(pty_port.url, 9600, timeout=0) as client:
        client.write(TO_38400)
        pty_port.pump(1.0)
        pty_port.pump(2.0)
        assert client.read(100) == MODE_OK
        client.baudrate = 38400
        client.write(READ_ERRORS)
        pty_port.pump(3.0)
        pty_port.pump(4.0)
        assert client.read(100) == NO_ERRORS


def test_pty_without_a_reader_does_not_block(pty_port: PtyPort) -> None:
    with serial.Serial(pty_port.url, 9600, timeout=0) as client:
        for t in range(5000):
            client.write(READ_ERRORS)
            pty_port.pump(float(t))
        assert len(client.read(100000)) < 5000 * len(NO_ERRORS)


def test_closed_pty_disconnects_its_client() -> None:
    port = PtyPort(Lms200Emulator())
    with serial.Serial(port.url, 9600, timeout=1.0) as client:
        port.close()
        port.close()
        with pytest.raises((serial.SerialException, termios.error)):
            client.read(1)


def test_tcp_client_receives_the_reply(tcp_port: TcpPort) -> None:
    with connect(tcp_port) as client:
        client.sendall(READ_ERRORS)
        tcp_port.pump(1.0)
        tcp_port.pump(2.0)
        assert client.recv(100) == NO_ERRORS


def test_tcp_serves_one_client_at_a_time(tcp_port: TcpPort) -> None:
    with connect(tcp_port) as first:
        with connect(tcp_port) as second:
            assert second.recv(1) == b""
        first.sendall(READ_ERRORS)
        tcp_port.pump(1.0)
        tcp_port.pump(2.0)
        assert first.recv(100) == NO_ERRORS
    tcp_port.pump(3.0)
    with connect(tcp_port) as third:
        third.sendall(READ_ERRORS)
        tcp_port.pump(4.0)
        tcp_port.pump(5.0)
        assert third.recv(100) == NO_ERRORS


def test_tcp_client_that_resets_is_replaced_by_the_next(tcp_port: TcpPort) -> None:
    client = connect(tcp_port)
    client.sendall(READ_ERRORS)
    client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")  # reset, not FIN
    client.close()
    tcp_port.pump(1.0)
    tcp_port.pump(2.0)
    with connect(tcp_port) as again:
        again.sendall(READ_ERRORS)
        tcp_port.pump(3.0)
        tcp_port.pump(4.0)
        assert again.recv(100) == NO_ERRORS


def test_closed_tcp_port_disconnects_its_client() -> None:
    port = TcpPort(Lms200Emulator())
    with connect(port) as client:
        port.close()
        port.close()
        assert client.recv(1) == b""
