"""The shipped session with the shipped emulator over real TCP, threads and ports included."""

from __future__ import annotations

import queue
import threading
import time

import numpy as np
import pytest

from drivers.emulation.port import TcpPort
from drivers.link import Link
from drivers.lms1xx.emulator.emulator import Lms1xxEmulator
from drivers.lms1xx.framing import Dialect
from drivers.lms1xx.session import Lms1xxSession, SessionState
from drivers.lms1xx.settings import LaserSettings
from drivers.requests import Write
from drivers.scan import Scan
from tests.drivers.lms1xx.conftest import ramp
from tests.drivers.pumped import pumped

LIMIT = 10.0  # s, generous: nothing waits that long when it works


class Host:
    """A session on a link, on the test's thread."""

    def __init__(self, session: Lms1xxSession) -> None:
        self.session = session
        self.events: queue.Queue[tuple[str, float, object]] = queue.Queue()
        self.scans: list[Scan] = []

    def received(self, t: float, data: bytes) -> None:
        self.events.put(("received", t, data))

    def link_up(self, t: float) -> None:
        self.events.put(("up", t, None))

    def link_down(self, t: float, reason: str) -> None:
        self.events.put(("down", t, reason))

    def run_until_scans(self, link: Link, count: int) -> None:
        wanted, give_up = len(self.scans) + count, time.monotonic() + LIMIT
        while len(self.scans) < wanted:
            assert time.monotonic() < give_up, self.session.state
            self._handle_one()
            for request in self.session.pop_requests():
                assert isinstance(request, Write)
                link.write(request.data)

    def _handle_one(self) -> None:
        try:
            kind, t, what = self.events.get(timeout=0.05)
        except queue.Empty:
            self.session.tick(time.monotonic())
            return
        if kind == "up":
            self.session.link_up(t)
        elif kind == "down":
            self.session.link_down(t)
        else:
            assert isinstance(what, bytes)
            self.scans += self.session.feed(what, t)


@pytest.mark.parametrize("dialect", Dialect)
def test_scans_come_and_come_again_after_the_network_was_gone(dialect: Dialect) -> None:
    emulator = Lms1xxEmulator(scan_source=ramp, dialect=dialect)
    port, lock = TcpPort(emulator), threading.Lock()
    with pumped(port, lock) as url:
        host = Host(Lms1xxSession(LaserSettings(url=url)))
        link = Link(url, LaserSettings().baud, host, time.monotonic)
        link.start()
        try:
            host.run_until_scans(link, 3)
            with lock:
                port.unplug()
            while host.session.state is not SessionState.DOWN:
                host._handle_one()
            with lock:
                port.plug_in()
            host.run_until_scans(link, 3)
        finally:
            link.close()
    assert host.session.trouble is None
    assert host.session.framer.counters.discarded_bytes == 0
    assert host.scans[-1].ranges == pytest.approx(np.linspace(1.0, 5.0, 541), abs=0.0006)
