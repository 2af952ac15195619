"""How the agent's process fares: load, lateness, and whether recorder and network keep up.

None of this reaches the agent: it would not be the same in a replay.
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
"""An event whose effects come later than this after it has missed its deadline."""

_MEMORY = Path("/proc/self/statm")


class ProcessWatch:
    """Collects the lateness of events; gives a report once a second."""

    def __init__(self, robot: str, start_wall_ns: int) -> None:
        """Report on the process of a robot whose time 0 was at ``start_wall_ns``."""
        self._robot = robot
        self._start_wall_ns = start_wall_ns
        self._lateness: list[float] = []
        self._pause = 0.0
        self._last_done = 0.0
        self._reported = 0.0
        self._cpu = time.process_time()

    def handled(self, happened: float, done: float) -> bool:
        """Take note of an event and when its effects were out, s; tell whether a report is due."""
        self._lateness.append(done - happened)
        self._pause = max(self._pause, done - self._last_done)
        self._last_done = done
        return done - self._reported >= PERIOD_S

    def report(
        self, lost: int, trouble: str, dropped: int, operator: bool | None = None
    ) -> ProcessPayload:
        """Return what was seen since the last report, and start anew.

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
    """Return the resident memory, MB; 0 where the system does not say."""
    try:
        pages = int(_MEMORY.read_text().split()[1])
    except OSError:
        return 0.0
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20
