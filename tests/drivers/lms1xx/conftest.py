"""A network between the shipped session and the shipped emulator, under a virtual clock."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from drivers.lms1xx.emulator.emulator import Lms1xxEmulator
from drivers.lms1xx.framing import Dialect, TelegramFramer
from drivers.lms1xx.session import Lms1xxSession, SessionState
from drivers.lms1xx.settings import LaserSettings
from drivers.requests import Write
from drivers.scan import Scan

STEP = 0.001  # s
TICK = 0.05  # s


def ramp(t: float, n: int, increment: float) -> NDArray[np.float64]:
    return np.linspace(1.0, 5.0, n)


class Network:
    """Carries bytes at once; ``spoil`` changes what the scanner sends."""

    def __init__(self, session: Lms1xxSession, emulator: Lms1xxEmulator) -> None:
        self.session = session
        self.emulator = emulator
        self.t = 0.0
        self.scans: list[Scan] = []
        self.commands: list[str] = []
        self.spoil: Callable[[bytes], bytes] = lambda data: data
        self._framer = TelegramFramer()
        self._next_tick = 0.0

    def connect(self) -> None:
        self.session.link_up(self.t)
        self._carry_out()

    def disconnect(self) -> None:
        self.session.link_down(self.t)

    def run(self, seconds: float) -> None:
        end = self.t + seconds
        while self.t < end:
            self._step()

    def run_until(self, state: SessionState, limit: float) -> float:
        """Run until the session is in a state; return the time it took, s."""
        begin = self.t
        while self.session.state is not state:
            assert self.t - begin < limit, f"still {self.session.state} after {limit} s"
            self._step()
        return self.t - begin

    def _step(self) -> None:
        self.t += STEP
        for item in self.emulator.pop_output(self.t):
            self.scans += self.session.feed(self.spoil(item.data), item.t)
        if self.t >= self._next_tick:
            self._next_tick += TICK
            self.session.tick(self.t)
        self._carry_out()

    def _carry_out(self) -> None:
        for request in self.session.pop_requests():
            assert isinstance(request, Write)
            self.commands += [each.command for each in self._framer.feed(request.data)]
            self.emulator.feed(request.data, self.t)


MakeNetwork = Callable[..., Network]


@pytest.fixture
def network() -> MakeNetwork:
    def make(
        settings: LaserSettings | None = None,
        emulator: Lms1xxEmulator | None = None,
        dialect: Dialect = Dialect.A,
    ) -> Network:
        session = Lms1xxSession(settings or LaserSettings())
        return Network(session, emulator or Lms1xxEmulator(scan_source=ramp, dialect=dialect))

    return make
