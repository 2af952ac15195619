"""One emulated robot in real time: steps its rig with the clock and pumps its ports."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Protocol

from tools.simulation.rig import RobotRig

STEP_S = 0.01
PUMP_S = 0.001
"""Largest delay of bytes at a port, s."""
MAX_LAG_S = 0.05
"""After a delay longer than this, s, a rig skips the missed steps instead of catching up."""


class Pumped(Protocol):
    """A port or cable of an emulated device."""

    def pump(self, t: float) -> None:
        """Move bytes both ways at ``t``, without waiting."""


class RealTimeRig:
    """Steps a rig on ``time.monotonic()``; call ``step`` in a loop."""

    def __init__(self, rig: RobotRig, ports: Sequence[Pumped]) -> None:
        self.rig = rig
        self._ports = ports
        self._next_step = time.monotonic()

    def step(self) -> float:
        """Wait for the next step's time, execute the step and return that time."""
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
