"""Where the time and the telemetry of a watch come from: now, or a recording."""

from __future__ import annotations

import time
from typing import Any, Protocol

from tools.monitor.watch import Watch


class Source(Protocol):
    """Moves a watch on; a page may steer it."""

    @property
    def epoch(self) -> int:
        """Changes when the watch begins afresh: pages must forget what they have."""

    def advance(self, watch: Watch) -> None:
        """Move the watch on to the present."""

    def steer(self, *, pause: bool | None, speed: float | None, seek: float | None) -> None:
        """Do as a page asks: hold or go on, at a speed (x real time), from a time (s)."""

    def description(self) -> dict[str, Any]:
        """Return what the page shows of the source."""


class LiveSource:
    """The present: the team is fed by the operator's session."""

    epoch = 0

    def advance(self, watch: Watch) -> None:
        """Look at the team now."""
        watch.advance(time.monotonic(), time.time())

    def steer(self, *, pause: bool | None, speed: float | None, seek: float | None) -> None:
        """The present can be neither held nor left."""

    def description(self) -> dict[str, Any]:
        """Return what the page shows: that this is live."""
        return {"kind": "live"}
