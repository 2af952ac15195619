"""Monitoring of the agent's process: load, lateness, losses of recorder and network.

None of this is an input of the agent, as a replay could not reproduce it.
"""

from __future__ import annotations

import os
import time
from pathlib import Path
from statistics import median

from robot_agent.messages.foxglove import timestamp_at
from robot_agent.messages.streams import ProcessPayload

PERIOD_S = 1.0
DEADLINE_S = 0.05
"""s from an event to its effects; an event with a longer delay has missed its deadline."""

_MEMORY = Path("/proc/self/statm")


class ProcessWatch:
    """Collects the lateness of events; builds a report every PERIOD_S."""

    def __init__(self, robot: str, start_wall_ns: int) -> None:
        """robot: name; start_wall_ns: wall clock at agent time 0, ns since 1970."""
        self._robot = robot
        self._start_wall_ns = start_wall_ns
        self._lateness: list[float] = []
        self._pause = 0.0
        self._last_done = 0.0
        self._reported = 0.0
        self._cpu = time.process_time()

    def handled(self, happened: float, done: float) -> bool:
        """Record the times of an event and of its last effect; return whether a report is due."""
        self._lateness.append(done - happened)
        self._pause = max(self._pause, done - self._last_done)
        self._last_done = done
        return done - self._reported >= PERIOD_S

    def report(
        self, lost: int, trouble: str, dropped: int, operator: bool | None = None
    ) -> ProcessPayload:
        """Return the report since the last one, and reset.

        lost, trouble: of the recorder; dropped: by the network, both since the start; operator:
        whether the operator is connected.
        """
        now, cpu = self._last_done, time.process_time()
        lateness = sorted(self._lateness)
        payload = ProcessPayload(
            timestamp=timestamp_at(now, self._start_wall_ns),
            robot=self._robot,
            cpu=round((cpu - self._cpu) / max(now - self._reported, PERIOD_S), 4),
            memory_mb=round(_resident_mb(), 1),
            events=len(lateness),
            lateness_median=round(median(lateness), 6),
            lateness_max=round(lateness[-1], 6),
            deadline_misses=sum(late > DEADLINE_S for late in lateness),
            longest_pause=round(self._pause, 6),
            recorder_lost=lost,
            recorder_trouble=trouble,
            telemetry_dropped=dropped,
            operator=operator,
        )
        self._lateness.clear()
        self._pause, self._cpu, self._reported = 0.0, cpu, now
        return payload


def _resident_mb() -> float:
    """Return the resident memory, MB (2^20 bytes); 0 where the system does not report it."""
    try:
        pages = int(_MEMORY.read_text().split()[1])
    except OSError:
        return 0.0
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20
