"""pyserial's URLs as ports: open, read, write, change of rate, loss and close."""

from __future__ import annotations

import os
import select
import socket
import threading
import time
import tty
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

import numpy as np
import pytest
import serial
from serial import rfc2217

from drivers.emulation.port import PtyPort
from drivers.lms200.emulator.emulator import Lms200Emulator
from drivers.lms200.session import Lms200Session
from drivers.lms200.settings import LaserSettings
from drivers.p2os.base_state import BaseState
from drivers.p2os.emulator.emulator import P2osEmulator
from drivers.p2os.emulator.make import PIONEER_2DX
from drivers.p2os.session import P2osSession, SessionState
from drivers.p2os.settings import BaseSettings
from drivers.port import Port, open_port
from drivers.port_error import PortError, PortTrouble
from tools.preflight.device_trial import DeviceTrial, run_trials

pytestmark = [  # of pyserial's rfc2217
    pytest.mark.filterwarnings("ignore:set(Daemon|Name):DeprecationWarning"),
    pytest.mark.filterwarnings("ignore:unclosed <socket:ResourceWarning"),
]
PATIENCE_S = 10.0


class PtyLine(serial.Serial):
    """A pty as a serial port with simulated modem lines."""

    cts = dsr = ri = cd = False

    def _update_dtr_state(self) -> None:
        pass

    def _update_rts_state(self) -> None:
        pass


class Client:
    """A connection whose bytes a PortManager may send from several threads."""

    def __init__(self, connection: socket.socket) -> None:
        self._connection = connection
        self._lock = threading.Lock()

    def write(self, data: bytes) -> None:
        with self._lock:
            self._connection.sendall(data)


def serve(listener: socket.socket, device: str, ended: threading.Event) -> None:
    """Run a device server of one serial port with pyserial's PortManager."""
    while not ended.is_set():
        try:
            connection, _ = listener.accept()
        except TimeoutError:
            continue
        with connection, PtyLine(device, 9600, timeout=0) as port:
            manager = rfc2217.PortManager(port, Client(connection))
            while not ended.is_set():
                ready, _, _ = select.select([connection, port], [], [], 0.02)
                if connection in ready:
                    data = connection.recv(1024)
                    if not data:
                        break
                    port.write(b"".join(manager.filter(data)))
                if port in ready:
                    connection.sendall(b"".join(manager.escape(port.read(1024))))


@contextmanager
def device_server(device: str) -> Iterator[str]:
    """Serve a device; yield its URL."""
    ended = threading.Event()
    with socket.create_server(("127.0.0.1", 0)) as listener:
        listener.settimeout(0.1)
        thread = threading.Thread(target=serve, args=(listener, device, ended))
        thread.start()
        try:
            yield f"rfc2217://127.0.0.1:{listener.getsockname()[1]}"
        finally:
            ended.set()
            thread.join()


@contextmanager
def running(port: PtyPort, step: Callable[[float], object] = float) -> Iterator[str]:
    ended = threading.Event()

    def pump() -> None:
        while not ended.wait(0.002):
            t = time.monotonic()
            step(t)
            port.pump(t)

    thread = threading.Thread(target=pump)
    thread.start()
    try:
        yield port.url
    finally:
        ended.set()
        thread.join()
        port.close()


@contextmanager
def opened(url: str, baud: int = 9600) -> Iterator[Port]:
    port = open_port(url, baud)
    try:
        yield port
    finally:
        port.close()


def heard(port: Port, count: int) -> bytes:
    """Return ``count`` bytes, waiting for them as a link does."""
    data = b""
    give_up = time.monotonic() + PATIENCE_S
    while len(data) < count:
        assert time.monotonic() < give_up, f"only {data!r}"
        if select.select([port.fileno()], [], [], 0.1)[0]:
            data += port.read()
    return data


@pytest.fixture
def terminal() -> Iterator[tuple[int, str]]:
    """The master of a pty, and its device."""
    master, slave = os.openpty()
    tty.setraw(slave)
    yield master, os.ttyname(slave)
    os.close(master)
    os.close(slave)


def test_base_behind_a_device_server_gets_ready() -> None:
    """The server's rate is effective: at another rate the emulated base's bytes are garbled."""
    session = P2osSession(BaseSettings())
    robot = P2osEmulator(PIONEER_2DX, baud=19200)
    got_ready: list[float] = []

    def ready_and_heard(states: Sequence[tuple[float, BaseState]]) -> bool:
        if session.state is SessionState.READY and states:
            got_ready.append(states[-1][0])
        return bool(got_ready)

    with running(PtyPort(robot), robot.advance) as device, device_server(device) as url:
        trial = DeviceTrial(url, 9600, session, ready_and_heard)
        run_trials([trial], 30.0)
    assert trial.line.lost == ""
    assert got_ready
    assert trial.line.bauds_tried[-1] == 19200


def test_laser_behind_a_device_server_streams_at_its_working_rate() -> None:
    session = Lms200Session(LaserSettings(baud=38400))
    laser = Lms200Emulator(baud=9600, scan_source=lambda t, n, step: np.linspace(1.0, 3.0, n))
    with running(PtyPort(laser)) as device, device_server(device) as url:
        trial = DeviceTrial(url, 9600, session, lambda scans: len(scans) > 5)
        run_trials([trial], 20.0)
        assert trial.done
    assert trial.line.lost == ""
    assert laser.baud == 38400


def test_device_server_hang_up_is_reported(terminal: tuple[int, str]) -> None:
    with device_server(terminal[1]) as url:
        with opened(url) as port:
            port.write(b"\xff\x00out")
            port.drain()
            assert os.read(terminal[0], 100)[:2] == b"\xff\x00"
            os.write(terminal[0], b"\xffin")
            assert heard(port, 3) == b"\xffin"
            server = url
        port = open_port(url, 9600)
    with pytest.raises(PortError, match=rf"{server} is lost: .*; check cable") as lost:
        heard(port, 1)
    assert lost.value.trouble is PortTrouble.HUNG_UP
    with pytest.raises(PortError, match="is lost"):
        port.drain()
    port.close()


def test_missing_device_server_is_reported() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        number = server.getsockname()[1]
    with pytest.raises(PortError, match=r"nothing listens at rfc2217://127\.0\.0\.1") as refused:
        open_port(f"rfc2217://127.0.0.1:{number}", 9600)
    assert refused.value.trouble is PortTrouble.REFUSED


def test_server_without_rfc2217_is_refused() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        url = f"rfc2217://127.0.0.1:{server.getsockname()[1]}?timeout=0.3"
        with pytest.raises(PortError, match="does not seem to support RFC2217") as refused:
            open_port(url, 9600)
    assert "\n" not in str(refused.value)


def test_loop_url_returns_written_bytes() -> None:
    threads = threading.active_count()
    with opened("loop://") as port:
        assert port.read() == b""
        assert port.write(b"hello") == 5
        assert heard(port, 5) == b"hello"
        port.write(b"old")
        port.set_baud(19200)
        port.write(b"new")
        assert heard(port, 3) == b"new"
        with pytest.raises(PortError, match="cannot run at -1 baud") as refused:
            port.set_baud(-1)
        assert refused.value.trouble is PortTrouble.BAD_RATE
    assert threading.active_count() == threads


def test_unread_bytes_are_not_lost(terminal: tuple[int, str]) -> None:
    master, device = terminal
    sent = bytes(range(256)) * 4096
    with opened(f"spy://{device}") as port:
        writer = threading.Thread(target=lambda: os.write(master, sent))
        writer.start()
        time.sleep(0.3)
        assert heard(port, len(sent)) == sent
        writer.join()


def test_spy_url_logs_the_traffic(
    terminal: tuple[int, str], capsys: pytest.CaptureFixture[str]
) -> None:
    master, device = terminal
    with opened(f"spy://{device}") as port:
        port.write(b"hello")
        assert os.read(master, 100) == b"hello"
        os.write(master, b"world")
        assert heard(port, 5) == b"world"
        port.set_baud(38400)
        assert tty.tcgetattr(master)[5] == tty.B38400
    text = capsys.readouterr().err
    assert "hello" in text
    assert "TX" in text
    assert "RX" in text


def test_stalled_and_lost_spied_device_is_reported(terminal: tuple[int, str]) -> None:
    with opened(f"spy://{terminal[1]}") as port:
        while port.write(bytes(65536)):
            pass
        with pytest.raises(PortError, match=r"stalled|Write timeout"):
            port.drain()


def test_hwgrep_url_finds_the_port(
    terminal: tuple[int, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    found = [(terminal[1], "FT232R", "USB VID:PID=0403:6001")]
    monkeypatch.setattr(
        "serial.tools.list_ports.grep", lambda what: found if what == "0403" else []
    )
    with opened("hwgrep://0403") as port:
        port.write(b"hello")
        assert os.read(terminal[0], 100) == b"hello"
    with pytest.raises(PortError, match="no such port: hwgrep://9999; check cable") as missing:
        open_port("hwgrep://9999", 9600)
    assert missing.value.trouble is PortTrouble.MISSING


@pytest.mark.parametrize(
    ("url", "says"),
    [
        ("hwgrep://[", "cannot open hwgrep://"),
        ("loop://?what=1", "cannot open loop://"),
        ("spy:///dev/no-such-port", "no such port"),
        ("rfc2217://127.0.0.1:70000", "bad port number"),
        ("cp2110://", "unknown kind of port"),
        ("://", "unknown kind of port"),
    ],
)
def test_invalid_urls_are_refused(url: str, says: str) -> None:
    with pytest.raises(PortError, match=says) as refused:
        open_port(url, 9600)
    assert "\n" not in str(refused.value)
