"""The agent's events as lines for a terminal or the system's journal."""

from __future__ import annotations

from typing import TextIO

from robot_agent.foxglove import Log, LogLevel
from robot_agent.streams import decode


class Journal:
    """Writes one line per event: severity, part, message. The journal adds its own time."""

    def __init__(self, out: TextIO) -> None:
        """Write to ``out``, normally standard error."""
        self._out = out

    def write(self, payload: bytes) -> None:
        """Write a payload of the ``event`` stream; an output that is gone is no reason to stop."""
        event = decode("event", payload)
        assert isinstance(event, Log)
        severity = LogLevel(event.level).name.lower()
        try:
            print(f"{severity}: {event.name}: {event.message}", file=self._out, flush=True)
        except OSError:
            return
