"""The link with real threads over real ptys and TCP, against the emulated laser."""

from __future__ import annotations

import os
import queue
import select
import socket
import threading
import time
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from drivers.emulation.port import PtyPort, TcpPort
from drivers.link import LONGEST_PAUSE, Link, LinkState
from drivers.lms200.emulator.emulator import Lms200Emulator
from drivers.lms200.framing import Telegram, TelegramFramer, encode_telegram
from drivers.lms200.session import Lms200Session
from drivers.lms200.settings import LaserSettings
from drivers.port_error import PortTrouble
from drivers.requests import SetBaud
from drivers.scan import Scan
from tests.drivers.pumped import pumped

LIMIT = 10.0  # s, generous: nothing waits that long when it works
READ_TYPE = encode_telegram(b"\x3a")
TO_38400 = encode_telegram(b"\x20\x40")
STREAM = encode_telegram(b"\x20\x24")


class Heard:
    """A listener that queues all calls, as the agent's inbox does."""

    def __init__(self) -> None:
        self.events: queue.Queue[tuple[str, float, object]] = queue.Queue()

    def received(self, t: float, data: bytes) -> None:
        self.events.put(("received", t, data))

    def link_up(self, t: float) -> None:
        self.events.put(("up", t, None))

    def link_down(self, t: float, reason: str) -> None:
        self.events.put(("down", t, reason))

    def wait_for(self, kind: str) -> object:
        """Return the arguments of the next event of a kind; drop others before it."""
        while True:
            heard, _t, what = self.events.get(timeout=LIMIT)
            if heard == kind:
                return what

    def wait_for_telegram(self) -> Telegram:
        framer = TelegramFramer()
        while True:
            data = self.wait_for("received")
            assert isinstance(data, bytes)
            for item in framer.feed(data):
                if isinstance(item, Telegram):
                    return item


@contextmanager
def linked(url: str, baud: int = 9600) -> Iterator[tuple[Link, Heard]]:
    heard = Heard()
    link = Link(url, baud, heard, time.monotonic)
    link.start()
    try:
        yield link, heard
    finally:
        link.close()


def read_exactly(descriptor: int, count: int) -> bytes:
    data = b""
    while len(data) < count:
        assert select.select([descriptor], [], [], LIMIT)[0], f"only {data!r} came"
        data += os.read(descriptor, 100)
    return data


def wait_until(condition: Callable[[], bool]) -> None:
    give_up = time.monotonic() + LIMIT
    while not condition():
        assert time.monotonic() < give_up
        time.sleep(0.005)


def laser(baud: int = 9600) -> Lms200Emulator:
    return Lms200Emulator(baud=baud, scan_source=lambda t, n, step: np.linspace(1.0, 3.0, n))


Port = Callable[[Lms200Emulator], PtyPort | TcpPort]
both_ports = pytest.mark.parametrize("make_port", [PtyPort, TcpPort])


@both_ports
def test_bytes_flow_both_ways(make_port: Port) -> None:
    with pumped(make_port(laser())) as url, linked(url) as (link, heard):
        heard.wait_for("up")
        link.write(READ_TYPE)
        assert heard.wait_for_telegram().code == 0xBA
        assert link.counters.bytes_out == len(READ_TYPE)
        assert link.counters.bytes_in > 20
        assert link.state is LinkState.UP


@both_ports
@pytest.mark.parametrize("start_baud", [9600, 38400])
def test_session_on_a_link_gets_scans(make_port: Port, start_baud: int) -> None:
    settings = LaserSettings(baud=38400 if start_baud == 38400 else 9600)
    session = Lms200Session(settings)
    scans: list[Scan] = []
    arrivals: list[float] = []
    with pumped(make_port(laser(start_baud))) as url, linked(url, settings.baud) as (link, heard):
        give_up = time.monotonic() + LIMIT
        while len(scans) < 2:
            assert time.monotonic() < give_up, session.state
            try:
                kind, t, what = heard.events.get(timeout=0.05)
            except queue.Empty:
                session.tick(time.monotonic())
            else:
                if kind == "up":
                    session.link_up(t)
                elif isinstance(what, bytes):
                    found = session.feed(what, t)
                    scans += found
                    arrivals += [t] * len(found)
            for request in session.pop_requests():
                if isinstance(request, SetBaud):
                    link.set_baud(request.baud)
                else:
                    link.write(request.data)
    wire_time = 372 * 10 / settings.baud
    assert scans[0].ranges[0] == pytest.approx(1.0)
    assert scans[0].ranges[-1] == pytest.approx(3.0)
    assert scans[0].t == pytest.approx(arrivals[0] - wire_time - 0.00666, abs=1e-6)


def test_rate_change_is_followed_by_both_ends() -> None:
    with pumped(PtyPort(laser())) as url, linked(url) as (link, heard):
        heard.wait_for("up")
        link.write(TO_38400)
        assert heard.wait_for_telegram().payload[:2] == b"\xa0\x00"
        link.set_baud(38400)
        link.write(READ_TYPE)
        assert heard.wait_for_telegram().code == 0xBA


def test_rate_mismatch_garbles_bytes() -> None:
    with pumped(PtyPort(laser(38400))) as url, linked(url, 38400) as (link, heard):
        heard.wait_for("up")
        link.write(STREAM)
        while heard.wait_for_telegram().code != 0xB0:
            pass
        link.set_baud(9600)
        received = b""
        while len(received) < 4 * 732:
            data = heard.wait_for("received")
            assert isinstance(data, bytes)
            received += data
        framer = TelegramFramer()
        framer.feed(received[2 * 732 :])
        framer.flush()
        assert framer.counters.good == 0
        link.set_baud(38400)
        assert heard.wait_for_telegram().code == 0xB0


def test_link_recovers_after_a_pty_is_replugged(tmp_path: Path) -> None:
    device = tmp_path / "laser"
    with linked(str(device)) as (link, heard):
        reason = heard.wait_for("down")
        assert isinstance(reason, str)
        assert reason.startswith(f"no such port: {device}")
        for _ in range(2):
            with pumped(PtyPort(laser())) as url:
                device.symlink_to(url)
                heard.wait_for("up")
                link.write(READ_TYPE)
                assert heard.wait_for_telegram().code == 0xBA
                device.unlink()
            reason = heard.wait_for("down")
            assert isinstance(reason, str)
            assert reason == f"device is gone: was {device} unplugged?"
        assert link.counters.times_up == link.counters.times_lost == 2


def test_link_recovers_after_a_tcp_server_returns() -> None:
    port = TcpPort(laser())
    number = int(port.url.rsplit(":", 1)[1])
    with linked(port.url) as (link, heard):
        with pumped(port):
            heard.wait_for("up")
            link.write(READ_TYPE)
            assert heard.wait_for_telegram().code == 0xBA
        assert heard.wait_for("down") == "connection closed by the other side"
        reason = heard.wait_for("down")
        assert isinstance(reason, str)
        assert reason.startswith(f"nothing listens at {port.url}")
        with pumped(TcpPort(laser(), number)):
            heard.wait_for("up")
            link.write(READ_TYPE)
            assert heard.wait_for_telegram().code == 0xBA


def test_status_contains_trouble_and_remedy(tmp_path: Path) -> None:
    device = tmp_path / "laser"
    with linked(str(device)) as (link, heard):
        heard.wait_for("down")
        status = link.status
        assert (status.state, status.trouble) == (LinkState.DOWN, PortTrouble.MISSING)
        assert "check cable and name" in status.reason
        assert status.port == str(device)
        with pumped(PtyPort(laser(), device)):
            heard.wait_for("up")
            status = link.status
            assert (status.state, status.trouble, status.reason) == (LinkState.UP, None, "")
        heard.wait_for("down")
        assert link.status.trouble in (PortTrouble.UNPLUGGED, PortTrouble.MISSING)
    assert link.status.state is LinkState.CLOSED


def test_returned_cable_is_noticed_within_half_a_second() -> None:
    assert LONGEST_PAUSE <= 0.5


def test_adapter_under_another_device_name_is_found(tmp_path: Path) -> None:
    lasting = tmp_path / "usb-adapter"
    heard = Heard()
    with pumped(PtyPort(laser())) as new_url:
        with pumped(PtyPort(laser())) as url:
            lasting.symlink_to(url)
            link = Link(url, 9600, heard, time.monotonic, tmp_path)
            link.start()
            heard.wait_for("up")
            assert link.status.port == url
            lasting.unlink()
        heard.wait_for("down")
        lasting.symlink_to(new_url)
        heard.wait_for("up")
        assert link.status.port == str(lasting)
        link.write(READ_TYPE)
        assert heard.wait_for_telegram().code == 0xBA
        link.close()


def test_same_trouble_is_reported_once(tmp_path: Path) -> None:
    device = tmp_path / "laser"
    with linked(str(device)) as (link, heard):
        heard.wait_for("down")
        with pumped(PtyPort(laser())) as url:
            give_up = time.monotonic() + LIMIT
            while link.counters.attempts < 3:
                assert time.monotonic() < give_up
                time.sleep(0.01)
            device.symlink_to(url)
            kind, _t, _what = heard.events.get(timeout=LIMIT)
            assert kind == "up"


def test_port_in_use_is_reported_and_opened_when_free() -> None:
    with pumped(PtyPort(laser())) as url, linked(url) as (first, first_heard):
        first_heard.wait_for("up")
        with linked(url) as (second, heard):
            assert (
                heard.wait_for("down") == f"{url} is in use by another process: end that one first"
            )
            assert second.state is LinkState.DOWN
            first.write(READ_TYPE)
            assert first_heard.wait_for_telegram().code == 0xBA
            first.close()
            heard.wait_for("up")


@pytest.mark.parametrize("kind", ["pty", "tcp"])
def test_stalled_output_takes_the_link_down(kind: str) -> None:
    if kind == "pty":
        master, slave = os.openpty()
        tty.setraw(slave)
        url = os.ttyname(slave)
        ends: list[Callable[[], None]] = [lambda: os.close(master), lambda: os.close(slave)]
    else:
        server = socket.create_server(("127.0.0.1", 0))
        url = f"socket://127.0.0.1:{server.getsockname()[1]}"
        ends = [server.close]
    try:
        with linked(url) as (link, heard):
            heard.wait_for("up")
            for _ in range(2000):
                link.write(bytes(60000))
                if not heard.events.empty():
                    break
            assert heard.wait_for("down") == f"output stalled: {url} takes no more bytes"
    finally:
        for end in ends:
            end()


def test_last_writes_are_sent_before_closing() -> None:
    master, slave = os.openpty()
    tty.setraw(slave)
    try:
        with linked(os.ttyname(slave)) as (link, heard):
            heard.wait_for("up")
            for number in range(50):
                link.write(bytes((number,)))
        assert read_exactly(master, 50) == bytes(range(50))
    finally:
        os.close(master)
        os.close(slave)


def test_order_of_writes_and_rate_changes_is_kept_at_any_rate() -> None:
    master, slave = os.openpty()
    tty.setraw(slave)
    try:
        with linked(os.ttyname(slave)) as (link, heard):
            heard.wait_for("up")
            for number, baud in enumerate([9600, 38400, 500000, 19200]):
                link.set_baud(baud)
                link.write(bytes((number, number)))
        assert read_exactly(master, 8) == bytes((0, 0, 1, 1, 2, 2, 3, 3))
        assert tty.tcgetattr(slave)[5] == tty.B19200
    finally:
        os.close(master)
        os.close(slave)


def test_port_that_closes_after_the_end_is_neither_reported_nor_opened_again() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        url = f"socket://127.0.0.1:{server.getsockname()[1]}"
        with linked(url) as (link, heard):
            device, _ = server.accept()
            heard.wait_for("up")
            link.write(b"close")
            link.end()
            device.settimeout(LIMIT)
            assert read_exactly(device.fileno(), 5) == b"close"
            device.close()
            wait_until(lambda: not link.alive)
            assert link.state is LinkState.CLOSED
            assert link.status.reason == ""
            assert (link.counters.times_lost, link.counters.attempts) == (0, 1)
            assert heard.events.empty()


def test_port_that_closes_before_the_end_is_reported() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        url = f"socket://127.0.0.1:{server.getsockname()[1]}"
        with linked(url) as (link, heard):
            device, _ = server.accept()
            heard.wait_for("up")
            device.close()
            assert "closed by the other side" in str(heard.wait_for("down"))
            link.end()
            link.write(b"lost")


def test_port_that_is_not_there_is_not_tried_again_after_the_end(tmp_path: Path) -> None:
    with linked(str(tmp_path / "missing")) as (link, heard):
        heard.wait_for("down")
        link.end()
        wait_until(lambda: not link.alive)


@both_ports
def test_close_ends_thread_and_descriptors(make_port: Port) -> None:
    with pumped(make_port(laser())) as url:
        before = set(Path("/proc/self/fd").iterdir())
        threads = threading.active_count()
        with linked(url) as (link, heard):
            heard.wait_for("up")
            assert threading.active_count() == threads + 1
            link.close()
            link.close()
            assert link.state is LinkState.CLOSED
            assert threading.active_count() == threads
            link.write(READ_TYPE)
            assert link.counters.bytes_dropped == len(READ_TYPE)
        if make_port is PtyPort:
            assert set(Path("/proc/self/fd").iterdir()) == before


def test_close_before_start_is_allowed_and_second_start_is_not() -> None:
    link = Link("/nonexistent", 9600, Heard(), time.monotonic)
    link.close()
    with linked("/nonexistent") as (started, _heard), pytest.raises(RuntimeError, match="once"):
        started.start()
