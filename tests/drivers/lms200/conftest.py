"""A serial line between the shipped session and the shipped emulator, under a virtual clock."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from drivers.lms200.emulator.emulator import Lms200Emulator
from drivers.lms200.session import Lms200Session, SessionState
from drivers.requests import SetBaud, Write
from drivers.scan import Scan

STEP = 0.002  # s
TICK = 0.05  # s


class Line:
    """Transmits bytes at the host's rate; bytes sent while the rates differ arrive garbled."""

    def __init__(self, session: Lms200Session, emulator: Lms200Emulator) -> None:
        self.session = session
        self.emulator = emulator
        self.t = 0.0
        self.host_baud = 9600
        self.scans: list[Scan] = []
        self.to_laser: list[bytes] = []
        self.from_laser: list[bytes] = []
        self.spoil: Callable[[bytes], bytes] = lambda data: data
        self.line_has_rate = True
        self._on_wire: list[tuple[float, int, bytes]] = []
        self._wire_free = 0.0
        self._next_tick = 0.0

    def connect(self) -> None:
        self.session.link_up(self.t)
        self._carry_out()

    def run(self, seconds: float) -> None:
        end = self.t + seconds
        while self.t < end:
            self._step()

    def run_until(self, state: SessionState, limit: float) -> float:
        """Run until the condition holds; return the time it took, s."""
        begin = self.t
        while self.session.state is not state:
            assert self.t - begin < limit, f"still {self.session.state} after {limit} s"
            self._step()
        return self.t - begin

    def _step(self) -> None:
        self.t += STEP
        while self._on_wire and self._on_wire[0][0] <= self.t:
            t, baud, data = self._on_wire.pop(0)
            self.emulator.feed(self.spoil(self._received(data, baud)), t)
        baud = self.emulator.baud
        for item in self.emulator.pop_output(self.t):
            data = self._received(item.data, self.host_baud, baud)
            self.from_laser.append(data)
            self.scans += self.session.feed(data, item.t)
            self._carry_out()
        if self.t >= self._next_tick:
            self._next_tick += TICK
            self.session.tick(self.t)
            self._carry_out()

    def _received(self, data: bytes, sent_at: int, read_at: int | None = None) -> bytes:
        matching = not self.line_has_rate or sent_at == (read_at or self.emulator.baud)
        return data if matching else bytes(octet ^ 0x5A for octet in data)

    def _carry_out(self) -> None:
        for request in self.session.pop_requests():
            if isinstance(request, SetBaud):
                self.host_baud = request.baud
            elif isinstance(request, Write):
                self.to_laser.append(request.data)
                begin = max(self.t, self._wire_free)
                self._wire_free = begin + len(request.data) * 10 / self.host_baud
                self._on_wire.append((self._wire_free, self.host_baud, request.data))


@pytest.fixture
def line() -> type[Line]:
    return Line
