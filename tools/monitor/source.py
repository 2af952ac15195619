"""Sources of a watch's time and telemetry: live, or a recording."""

from __future__ import annotations

import time
from typing import Any, Protocol

from tools.monitor.watch import Watch


class Source(Protocol):
    """Advances a watch; pages may steer it."""

    @property
    def epoch(self) -> int:
        """Changes when the watch is reset: pages must then be sent everything again."""

    def advance(self, watch: Watch) -> None:
        """Advance the watch to the source's present."""

    def steer(self, *, pause: bool | None, speed: float | None, seek: float | None) -> None:
        """Pause or resume, set the speed (x real time), seek (s since 1970); None: no change."""

    def description(self) -> dict[str, Any]:
        """Return the source's state for the page."""

    @property
    def listen(self) -> str:
        """The Zenoh endpoint that robots dial; empty where none can."""


class LiveSource:
    """The present time; the operator's session feeds the team."""

    epoch = 0

    def __init__(self, listen: str = "") -> None:
        """listen: the Zenoh endpoint of the operator's session."""
        self.listen = listen

    def advance(self, watch: Watch) -> None:
        """Advance the watch to now."""
        watch.advance(time.monotonic(), time.time())

    def steer(self, *, pause: bool | None, speed: float | None, seek: float | None) -> None:
        """Ignored: live telemetry cannot be paused or sought."""

    def description(self) -> dict[str, Any]:
        """Return the kind of source, ``live``."""
        return {"kind": "live"}
