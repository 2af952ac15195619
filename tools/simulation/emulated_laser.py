"""The scanner that an emulated robot carries: of the kind its truth says."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from drivers.emulation.timed_bytes import TimedBytes
from drivers.lms1xx.emulator import mirror as lms1xx_mirror
from drivers.lms1xx.emulator.emulator import Lms1xxEmulator
from drivers.lms200.emulator import mirror as lms200_mirror
from tools.simulation.laser_start import LaserStart
from tools.simulation.truth.robot_truth import ScannerKind

ScanSource = Callable[[float, int, float], NDArray[np.float64]]
"""(t, n, increment) -> ranges (n,) m at time t, rightmost beam first, inf for no return."""
ReflectorSource = Callable[[], NDArray[np.bool_] | None]
"""() -> (n,) beams of the latest turn measured that ended on a reflector, None for none."""


class EmulatedLaser(Protocol):
    """The scanner's side of its line, and its mirror."""

    @property
    def baud(self) -> int:
        """Its present rate."""

    def feed(self, data: bytes, t: float) -> None:
        """Take bytes from the client."""

    def pop_output(self, t: float) -> list[TimedBytes]:
        """Return what has left the wire by ``t``."""

    def advance(self, t: float) -> None:
        """Advance to ``t``: measure the scans that are due."""

    def turn_due(self, t: float) -> tuple[float, int, float, float] | None:
        """Return the mirror turn to be measured next by ``t``, None if there is none.

        Its middle (s), number of beams, angle between them (rad), and the end of its sweep (s).
        """

    def power_off(self, t: float) -> None:
        """Cut the power."""

    def power_on(self, t: float) -> None:
        """Switch on, or off and on."""


def make_laser(
    kind: ScannerKind,
    scan_source: ScanSource,
    reflector_source: ReflectorSource,
    start: LaserStart,
    t: float,
) -> EmulatedLaser:
    """Return a scanner of a kind that measures with a source; an LMS 1xx sees no reflectors.

    start: how an LMS 200 is found at ``t`` (s).
    """
    if kind == "lms1xx":
        return Lms1xxEmulator(scan_source=scan_source)
    return start.make(scan_source, reflector_source, t)


def beam_delays(laser: EmulatedLaser, n: int, increment: float) -> NDArray[np.float64]:
    """Return (n,) s, read-only, from the middle of a sweep until each beam is measured.

    increment: rad between beams.
    """
    if isinstance(laser, Lms1xxEmulator):
        return lms1xx_mirror.beam_delays(n, increment, laser.turn_time)
    return lms200_mirror.beam_delays(n, increment)
