"""The flight recorder: writes what happens to an agent to a file, on a thread of its own.

The agent's side only appends to a queue. The thread empties the queue ten times a second and once
a second finishes a chunk and has the disk take it, so that a killed process or a cut battery
costs at most about the last second. Whatever cannot be written is counted and marked as a gap.
"""

from __future__ import annotations

import os
import threading
from collections import deque
from pathlib import Path
from typing import BinaryIO

from robot_agent.effects import Effect
from robot_agent.events import Event
from robot_agent.recording_writer import Gap, RecordingWriter, RunHeader

__all__ = ["Recorder", "RecordingWriter", "RunHeader"]

DRAIN_S = 0.1
DRAINS_PER_FLUSH = 10
CAPACITY = 20_000
"""Records that may wait for the disk: about a minute of a robot's traffic."""


class Recorder:
    """Records one run to an MCAP file without ever holding the agent up.

    ``failed`` is empty while all is well, else one line that says what the disk refused; from then
    on nothing more is kept. ``lost`` counts the records that were turned away. One thread at a
    time may call the methods.
    """

    def __init__(
        self,
        path: Path,
        header: RunHeader,
        *,
        capacity: int = CAPACITY,
        drain_period: float = DRAIN_S,
    ) -> None:
        """Create the file, with its header, and start writing."""
        self.path = path
        self.failed = ""
        self.lost = 0
        self._capacity = capacity
        self._period = drain_period
        self._queue: deque[tuple[float, Event | Effect | Gap]] = deque()
        self._unmarked = 0  # lost since the last gap mark
        self._last_t = 0.0
        self._ending = threading.Event()
        self._thread = threading.Thread(
            target=self._run, args=(header,), name="recorder", daemon=True
        )
        self._thread.start()

    def record_event(self, event: Event) -> None:
        """Queue an event, before the agent handles it."""
        self._put(event.t, event)

    def record_effect(self, t: float, effect: Effect) -> None:
        """Queue an effect of the event that happened at t."""
        self._put(t, effect)

    def close(self) -> None:
        """Write what is queued and finish the file; idempotent."""
        if self._unmarked:
            self._mark_gap(self._last_t)
        self._ending.set()
        self._thread.join()

    def _put(self, t: float, record: Event | Effect) -> None:
        self._last_t = t
        if self.failed or len(self._queue) >= self._capacity:
            self.lost += 1
            self._unmarked += 1
            return
        if self._unmarked:
            self._mark_gap(t)
        self._queue.append((t, record))

    def _mark_gap(self, t: float) -> None:
        self._queue.append((t, Gap(t, self._unmarked)))
        self._unmarked = 0

    def _run(self, header: RunHeader) -> None:
        """Write until told to end; a refusal of the disk becomes ``failed``."""
        try:
            with self.path.open("wb") as file:
                self._write_run(file, header)
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            self.failed = f"{self.path}: recording stopped: {reason}"
            self._queue.clear()

    def _write_run(self, file: BinaryIO, header: RunHeader) -> None:
        """Write a whole recording; what was flushed is on the disk, not only on its way there."""
        writer = RecordingWriter(file, header)
        ending = False
        while not ending:
            writer.flush()
            os.fdatasync(file.fileno())
            for _ in range(DRAINS_PER_FLUSH):
                ending = self._ending.wait(self._period)
                self._drain(writer)
                if ending:
                    break
        writer.finish()
        file.flush()
        os.fdatasync(file.fileno())

    def _drain(self, writer: RecordingWriter) -> None:
        """Write everything queued by now."""
        for _ in range(len(self._queue)):
            t, record = self._queue.popleft()
            if isinstance(record, Gap):
                writer.write_gap(record)
            elif isinstance(record, Event):
                writer.write_event(record)
            else:
                writer.write_effect(t, record)
