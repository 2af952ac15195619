"""A device trial with the agent's sessions, on emulated devices behind pseudo-terminals."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from drivers.emulation.port import PtyPort, TcpPort
from drivers.emulation.timed_bytes import TimedBytes
from drivers.lms200.emulator.emulator import Lms200Emulator
from drivers.lms200.session import Lms200Session
from drivers.lms200.settings import LaserSettings
from drivers.lms200.telegrams import Mode, Variant
from drivers.p2os.base_state import BaseState
from drivers.p2os.emulator.emulator import P2osEmulator
from drivers.p2os.emulator.make import PIONEER_2DX
from drivers.p2os.session import P2osSession
from drivers.p2os.settings import BaseSettings
from drivers.scan import Scan
from tools.preflight.device_trial import DeviceTrial, run_trials
from tools.simulation.hanging_up_port import HangingUpPort

LIMIT = 20.0  # s; not reached in a passing test


@contextmanager
def served(port: PtyPort | TcpPort, hangs_up: P2osEmulator | None = None) -> Iterator[str]:
    """Pump an emulated device's port on a thread; yield its URL.

    hangs_up: the base whose port it is, which ends the connection after CLOSE.
    """
    device: PtyPort | TcpPort | HangingUpPort = port
    if hangs_up is not None:
        assert isinstance(port, TcpPort)
        device = HangingUpPort(port, hangs_up)
    ended = threading.Event()

    def pump() -> None:
        while not ended.wait(0.002):
            device.pump(time.monotonic())

    thread = threading.Thread(target=pump)
    thread.start()
    try:
        yield port.url
    finally:
        ended.set()
        thread.join()
        port.close()


def base_trial(url: str, reports: int) -> DeviceTrial[BaseState]:
    def enough(states: Sequence[tuple[float, BaseState]]) -> bool:
        return len(states) >= reports

    settings = BaseSettings(url=url)
    return DeviceTrial(url, settings.baud, P2osSession(settings), enough)


def test_base_at_another_rate_is_found_and_its_session_closed() -> None:
    emulator = P2osEmulator(PIONEER_2DX, baud=38400)
    with served(PtyPort(emulator)) as url:
        trial = base_trial(url, reports=3)
        run_trials([trial], LIMIT)
        assert trial.done
        assert trial.line.opened
        assert trial.line.bauds_tried == [9600, 38400]
        assert trial.line.last_bytes_baud == 38400
        assert trial.line.bytes_received > 0
        assert 0 < len(trial.line.last_bytes) <= 8
        assert len(trial.measurements) >= 3
        times = [t for t, _ in trial.measurements]
        assert times == sorted(times)
        assert emulator.counters.sessions == 1
        assert not emulator.session_open, "closed at the end"
        assert not emulator.motors_enabled


def test_base_that_hangs_up_after_close_is_no_lost_link() -> None:
    emulator = P2osEmulator(PIONEER_2DX)
    with served(TcpPort(emulator), hangs_up=emulator) as url:
        trial = base_trial(url, reports=3)
        run_trials([trial], LIMIT)
        assert trial.line.opened
        assert trial.line.lost == ""
        assert emulator.counters.sessions == 1
        assert not emulator.session_open


def test_laser_trial_ends_with_the_stream_stopped() -> None:
    emulator = Lms200Emulator(scan_source=lambda _t, n, _step: np.full(n, 2.0))
    settings = LaserSettings(resolution_deg=1.0)

    def enough(scans: Sequence[tuple[float, Scan]]) -> bool:
        return len(scans) >= 2

    with served(PtyPort(emulator)) as url:
        trial = DeviceTrial(url, settings.baud, Lms200Session(settings), enough)
        run_trials([trial], LIMIT)
        assert len(trial.measurements) >= 2
        assert emulator.mode == Mode.ON_REQUEST


def test_device_that_answers_slowly_has_more_time() -> None:
    emulator = Lms200Emulator(scan_source=lambda _t, n, _step: np.full(n, 2.0), baud=38400)
    emulator.state.variant = Variant(180, 100)
    emulator.state.configuration = emulator.state.configuration.changed(5, 1)
    emulator.slow = True
    session = Lms200Session(LaserSettings())
    with served(PtyPort(emulator)) as url:
        trial = DeviceTrial(
            url, 38400, session, lambda scans: len(scans) >= 2, lambda: session.answers
        )
        limit = 4.0  # s, in which even a busy machine finds the laser
        run_trials([trial], limit)
        assert trial.done
        assert trial.measurements[0][0] - trial.line.opened_at > limit


def test_missing_port_ends_the_trial_with_its_reason(tmp_path: Path) -> None:
    trial = base_trial(str(tmp_path / "nothing"), reports=1)
    progress: list[float] = []
    run_trials([trial], LIMIT, progress.append)
    assert trial.done
    assert "no such port" in trial.line.lost
    assert not trial.line.opened
    assert all(elapsed < LIMIT for elapsed in progress)


def test_silent_line_ends_the_trial_at_the_limit() -> None:
    class Silence:
        baud = 9600

        def feed(self, data: bytes, t: float) -> None:
            pass

        def pop_output(self, t: float) -> list[TimedBytes]:
            return []

    with served(PtyPort(Silence())) as url:
        trial = base_trial(url, reports=1)
        run_trials([trial], 0.8)
        assert not trial.done
        assert trial.line.bauds_tried[0] == 9600
        assert (trial.line.bytes_received, trial.line.last_bytes) == (0, b"")
