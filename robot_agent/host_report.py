"""What the operator hears of the agent's process: CPU, memory, what it had to drop.

Made by the runtime and not by the agent, whose payloads a replay must be able to reproduce.
"""

from __future__ import annotations

import os
import time
from pathlib import Path

from robot_agent.foxglove import timestamp_at
from robot_agent.recorder import Recorder
from robot_agent.streams import HostPayload, encode
from robot_agent.telemetry import Telemetry

PERIOD_S = 2.0
_STATM = Path("/proc/self/statm")


class HostReport:
    """Publishes a ``host`` payload every two seconds."""

    def __init__(
        self, robot: str, start_wall_ns: int, telemetry: Telemetry, recorder: Recorder | None
    ) -> None:
        """Report on the process that carries these."""
        self._robot = robot
        self._start_wall_ns = start_wall_ns
        self._telemetry = telemetry
        self._recorder = recorder
        self._reported_at = 0.0
        self._cpu = time.process_time()

    def tick(self, t: float) -> None:
        """Publish when it is time, at agent time t (s)."""
        if t - self._reported_at < PERIOD_S:
            return
        cpu = time.process_time()
        payload = HostPayload(
            timestamp=timestamp_at(t, self._start_wall_ns),
            robot=self._robot,
            cpu=round((cpu - self._cpu) / (t - self._reported_at), 4),
            memory=round(_resident_bytes() / 2**20, 1),
            telemetry_sent=self._telemetry.sent,
            telemetry_dropped=self._telemetry.dropped,
            recorder_lost=0 if self._recorder is None else self._recorder.lost,
            recorder_failed="" if self._recorder is None else self._recorder.failed,
        )
        self._reported_at, self._cpu = t, cpu
        self._telemetry.publish("host", encode(payload))


def _resident_bytes() -> int:
    """Memory of this process, bytes; 0 where the system does not tell."""
    try:
        pages = int(_STATM.read_text().split()[1])
    except OSError:
        return 0
    return pages * os.sysconf("SC_PAGE_SIZE")
