"""A writer beside the control loop: what may wait for a disk or a pipe runs on a thread of its own.

The control loop feeds the service's watchdog and must never wait: a disk that hangs would stop the
robot and have the agent killed.
"""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable

from robot_agent.recording.recorder import HANG_S

CLOSE_S = 1.0
"""s to wait for the last payloads at the end."""


class SideWriter:
    """Calls a function with payloads, in order, on its own thread.

    ``lost`` counts payloads dropped, the oldest first, because more than the capacity waited.
    """

    def __init__(self, name: str, write: Callable[[bytes], None], capacity: int) -> None:
        """Start the thread. write: must not raise. capacity: payloads that may wait."""
        self.lost = 0
        self._write = write
        self._waiting: deque[bytes] = deque()
        self._capacity = capacity
        self._changed = threading.Condition()
        self._ending = False
        self._writes_since = math.inf
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    @property
    def hangs(self) -> bool:
        """Whether the present write has taken HANG_S."""
        return time.monotonic() - self._writes_since > HANG_S

    def put(self, payload: bytes) -> None:
        """Queue a payload; never waits."""
        with self._changed:
            if len(self._waiting) >= self._capacity:
                self._waiting.popleft()
                self.lost += 1
            self._waiting.append(payload)
            self._changed.notify()

    def close(self, wait: float = CLOSE_S) -> bool:
        """Write what waits, within ``wait`` s; return whether all was written."""
        with self._changed:
            self._ending = True
            self._changed.notify()
        self._thread.join(wait)
        return not self._thread.is_alive()

    def _run(self) -> None:
        while True:
            with self._changed:
                while not self._waiting and not self._ending:
                    self._changed.wait()
                if not self._waiting:
                    return
                payload = self._waiting.popleft()
            self._writes_since = time.monotonic()
            self._write(payload)
            self._writes_since = math.inf
