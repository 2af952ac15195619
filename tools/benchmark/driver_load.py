"""CPU load of the driver threads at full sensor rate, with devices emulated in another process."""

from __future__ import annotations

import threading
import time
from multiprocessing.connection import Connection
from typing import Final

import numpy as np
from numpy.typing import NDArray

from drivers.emulation.port import PtyPort, TcpPort
from drivers.link import Link
from drivers.lms1xx.emulator.emulator import Lms1xxEmulator
from drivers.lms1xx.settings import LaserSettings as Lms1xxSettings
from drivers.lms200.emulator.emulator import Lms200Emulator
from drivers.lms200.settings import LaserSettings as Lms200Settings
from drivers.p2os.emulator.emulator import P2osEmulator
from drivers.p2os.emulator.make import PIONEER_2DX
from drivers.p2os.session import P2osSession
from drivers.p2os.settings import BaseSettings
from drivers.requests import SetBaud
from drivers.scanner import ScannerSession, ScannerSettings, kind_of, scanner_session
from tools.studies.worker_pool import START

LASER_BAUD: Final = 500_000
FULL_RATE: dict[str, ScannerSettings] = {
    "lms200": Lms200Settings(baud=LASER_BAUD, resolution_deg=0.5),
    "lms1xx": Lms1xxSettings(),
}
"""By kind, the settings with which a scanner sends most: 361 values, 541 at 50 Hz."""
TICK_PERIOD = 0.05  # s
_PUMP_PERIOD = 0.001  # s
_SET_UP_LIMIT = 20.0  # s


class LoadedDriver:
    """A session on its link: fed by the link's thread, ticked by the caller's."""

    def __init__(self, url: str, baud: int, session: ScannerSession | P2osSession) -> None:
        self.results = 0
        """Scans or base reports so far."""
        self._session = session
        self._lock = threading.Lock()
        self._link = Link(url, baud, self, time.monotonic)
        self._ident: int | None = None

    def start(self) -> None:
        """Open the port."""
        self._link.start()

    def close(self) -> None:
        """Close the port."""
        self._link.close()

    def received(self, t: float, data: bytes) -> None:
        """Decode bytes received at t; called by the link's thread."""
        with self._lock:
            self.results += len(self._session.feed(data, t))
            self._carry_out()

    def link_up(self, t: float) -> None:
        """Start the session; called by the link's thread."""
        self._ident = threading.get_ident()
        with self._lock:
            self._session.link_up(t)
            self._carry_out()

    def link_down(self, t: float, reason: str) -> None:  # noqa: ARG002 - a listener's signature
        """End the session; called by the link's thread."""
        with self._lock:
            self._session.link_down(t)

    def tick(self) -> None:
        """Tick the session at the present monotonic time."""
        with self._lock:
            self._session.tick(time.monotonic())
            self._carry_out()

    def thread_time(self) -> float:
        """Return the CPU time of the link's thread so far, s; 0 before the link is up."""
        if self._ident is None:
            return 0.0
        return time.clock_gettime(time.pthread_getcpuclockid(self._ident))

    def _carry_out(self) -> None:
        for request in self._session.pop_requests():
            if isinstance(request, SetBaud):
                self._link.set_baud(request.baud)
            else:
                self._link.write(request.data)


def driver_load(duration: float, laser: ScannerSettings) -> tuple[float, float, float]:
    """Run base and laser drivers for a duration, s, after their set-up.

    Return (share of one core of all driver threads and their ticks, scans/s, base reports/s).
    """
    pipe, child_end = START.Pipe()
    process = START.Process(target=_emulate_devices, args=(child_end, kind_of(laser)), daemon=True)
    process.start()
    laser_url, base_url = pipe.recv()
    drivers = [
        LoadedDriver(laser_url, laser.baud, scanner_session(laser)),
        LoadedDriver(base_url, 38400, P2osSession(BaseSettings(baud=38400))),
    ]
    try:
        for driver in drivers:
            driver.start()
        _tick_until(drivers, time.monotonic() + _SET_UP_LIMIT, until_results=True)
        before, before_count = _spent(drivers), [driver.results for driver in drivers]
        begin = time.monotonic()
        _tick_until(drivers, begin + duration)
        elapsed = time.monotonic() - begin
        rates = [(d.results - h) / elapsed for d, h in zip(drivers, before_count, strict=True)]
        return (_spent(drivers) - before) / elapsed, rates[0], rates[1]
    finally:
        for driver in drivers:
            driver.close()
        pipe.send(None)
        process.join()


def _tick_until(drivers: list[LoadedDriver], end: float, *, until_results: bool = False) -> None:
    while time.monotonic() < end:
        if until_results and all(driver.results > 0 for driver in drivers):
            return
        for driver in drivers:
            driver.tick()
        time.sleep(TICK_PERIOD)


def _spent(drivers: list[LoadedDriver]) -> float:
    return time.thread_time() + sum(driver.thread_time() for driver in drivers)


def _emulate_devices(pipe: Connection, kind: str) -> None:
    """Emulate a laser of a kind and a base until the pipe gets a message."""

    def scene(_t: float, n: int, _increment: float) -> NDArray[np.float64]:
        return np.linspace(1.0, 7.0, n)

    base = P2osEmulator(PIONEER_2DX, baud=38400)
    laser = (
        TcpPort(Lms1xxEmulator(scan_source=scene))
        if kind == "lms1xx"
        else PtyPort(Lms200Emulator(baud=LASER_BAUD, scan_source=scene))
    )
    ports = [laser, PtyPort(base)]
    pipe.send(tuple(port.url for port in ports))
    begin = time.monotonic()
    while not pipe.poll(_PUMP_PERIOD):
        t = time.monotonic() - begin
        base.turn_odometer(*base.advance(t))
        for port in ports:
            port.pump(t)
    for port in ports:
        port.close()
