"""The gyro of an emulated robot, whose readings its controller passes on."""

from __future__ import annotations

import math

from drivers.p2os.extended_packets import GyroPacket, GyroSample

SAMPLE_PERIOD = 0.025  # s; ours
AT_REST = 512  # counts
COUNTS_PER_RADIAN = AT_REST / math.radians(300.0)
"""Counts per rad/s, of a gyro of 300 deg/s over its half range; ours."""
TEMPERATURE = 30  # counts; ours
MOST_SAMPLES = 8
"""Readings kept for one packet; older ones are lost. Ours."""


class EmulatedGyro:
    """Readings since the last packet, all of them of the present turn rate."""

    def __init__(self) -> None:
        self._since = 0.0

    def start(self, t: float) -> None:
        """Take readings from ``t`` on."""
        self._since = t

    def pop_packet(self, t: float, w: float) -> GyroPacket:
        """Return the readings up to ``t`` of a robot that turns at ``w`` rad/s."""
        taken = int((t - self._since) / SAMPLE_PERIOD + 1e-6)
        self._since += taken * SAMPLE_PERIOD
        rate = min(1023, max(0, round(AT_REST - COUNTS_PER_RADIAN * w)))
        return GyroPacket((GyroSample(rate, TEMPERATURE),) * min(max(taken, 0), MOST_SAMPLES))
