"""Output of the agent's events as lines for a terminal or the system's journal."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Protocol

from robot_agent.messages.foxglove import Log
from robot_agent.messages.log_level import LogLevel
from robot_agent.messages.streams import decode

_PRIORITY = {
    LogLevel.DEBUG: 7,
    LogLevel.INFO: 6,
    LogLevel.WARNING: 4,
    LogLevel.ERROR: 3,
    LogLevel.FATAL: 2,
}
"""Of syslog(3)."""


class LineOutput(Protocol):
    """What takes the lines: a file, a terminal."""

    def write(self, text: str, /) -> object:
        """Write a part of a line."""

    def flush(self) -> object:
        """Write out what was written."""


class Journal:
    """Writes one line per event: severity, part, message. The journal adds its own time.

    Under systemd's journal each line starts with its priority, as in sd-daemon(3).
    """

    def __init__(self, out: LineOutput, environment: Mapping[str, str] = os.environ) -> None:
        """Write to ``out``, normally standard error."""
        self._out = out
        self._journald = "JOURNAL_STREAM" in environment

    def write(self, payload: bytes) -> None:
        """Write a payload of the ``event`` stream; errors of the output are ignored."""
        event = decode("event", payload)
        assert isinstance(event, Log)
        level = LogLevel(event.level)
        mark = f"<{_PRIORITY.get(level, 5)}>" if self._journald else f"{level.name.lower()}: "
        words = " ".join(event.message.split())
        try:
            print(f"{mark}{event.name}: {words}", file=self._out, flush=True)
        except OSError:
            return
