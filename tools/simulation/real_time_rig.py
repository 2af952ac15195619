"""One emulated robot in real time: its rig stepped with the clock, its ports pumped."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Protocol

from tools.simulation.rig import RobotRig

STEP_S = 0.01
PUMP_S = 0.001
"""Bytes cross a port at most this late."""
MAX_LAG_S = 0.05
"""A rig held up longer than this lets the lost steps go instead of racing to catch up."""


class Pumped(Protocol):
    """A port or cable behind which an emulated device sits."""

    def pump(self, t: float) -> None:
        """Carry bytes both ways at time ``t`` (s, monotonic), without waiting."""


class RealTimeRig:
    """Steps a rig on ``time.monotonic()``; call ``step`` again and again."""

    def __init__(self, rig: RobotRig, ports: Sequence[Pumped]) -> None:
        self.rig = rig
        self._ports = ports
        self._next_step = time.monotonic()

    def step(self) -> float:
        """Wait for the next step's time, carry it out, and return that time (s, monotonic)."""
        while (wait := self._next_step - time.monotonic()) > 0.0:
            self._pump()
            time.sleep(min(wait, PUMP_S))
        now = self._pump()
        if now - self._next_step > MAX_LAG_S:
            self._next_step = now
        self._next_step += STEP_S
        self.rig.advance(now)
        return now

    def _pump(self) -> float:
        now = time.monotonic()
        for port in self._ports:
            port.pump(now)
        return now
