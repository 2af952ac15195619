"""The flight recorder: writes an agent's events and effects to a file, on its own thread.

The agent's side only appends to a queue. The thread empties the queue ten times a second and every
0.5 s finishes a chunk and syncs it to the disk, so that a killed process or a power cut costs at
most the last second. Records that cannot be written are counted and marked as a gap.
"""

from __future__ import annotations

import os
import threading
import time
from collections import deque
from pathlib import Path
from typing import BinaryIO

from robot_agent.messages.effects import Effect
from robot_agent.messages.events import Event
from robot_agent.recording.recording_retention import RecordingRetention
from robot_agent.recording.recording_writer import Gap, Note, RecordingWriter
from robot_agent.recording.run_header import RunHeader

DRAIN_S = 0.1
FLUSH_S = 0.5
CLOSE_S = 5.0
"""s to wait for a hanging disk at the end."""
CAPACITY = 20_000
"""Records that may wait for the disk: about a minute of a robot's traffic."""


class Recorder:
    """Records one run to an MCAP file without ever blocking the agent.

    ``failed`` is empty, or one line with the error after which nothing more is recorded. ``lost``
    counts the records that were dropped. One thread at a time may call the methods.
    """

    def __init__(
        self,
        path: Path,
        header: RunHeader,
        *,
        capacity: int = CAPACITY,
        drain_period: float = DRAIN_S,
        flush_period: float = FLUSH_S,
        close_wait: float = CLOSE_S,
        room: RecordingRetention | None = None,
    ) -> None:
        """Start the thread that creates the file with its header.

        capacity: records in the queue. drain_period, flush_period, close_wait: s. room: bounds the
        use of the disk; None: no bound.
        """
        self.path = path
        self.failed = ""
        self.lost = 0
        self._capacity = capacity
        self._period = drain_period
        self._flush_period = flush_period
        self._close_wait = close_wait
        self._room = room
        self._queue: deque[tuple[float, Event | Effect | Gap | Note]] = deque()
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

    def record_note(self, note: Note) -> None:
        """Queue a payload of the process."""
        self._put(note.t, note)

    def close(self) -> None:
        """Write the queue and finish the file, within ``close_wait``; idempotent."""
        if self._unmarked:
            self._mark_gap(self._last_t)
        self._ending.set()
        self._thread.join(self._close_wait)
        if self._thread.is_alive():
            self.failed = f"{self.path}: the disk hangs: the recording's end is lost"

    def _put(self, t: float, record: Event | Effect | Note) -> None:
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
        """Write until ``close``; an error of the disk, or of the thread, is set in ``failed``."""
        trouble = "its thread has died: start the agent again"
        try:
            with self.path.open("wb") as file:
                trouble = self._write_run(file, header)
        except (OSError, ValueError) as error:
            trouble = getattr(error, "strerror", None) or str(error)
        finally:
            if trouble:
                self.failed = f"{self.path}: recording stopped: {trouble}"
                self._queue.clear()

    def _write_run(self, file: BinaryIO, header: RunHeader) -> str:
        """Write a whole recording; return why it had to end early, empty if it did not.

        Every flush is synced to the disk.
        """
        writer = RecordingWriter(file, header)
        trouble, ending = "", False
        while not ending and not trouble:
            next_flush = time.monotonic() + self._flush_period  # however long the disk takes
            _flush(writer, file)
            trouble = self._room.free_space() if self._room else ""
            ending = self._write_until(next_flush, writer)
        writer.finish()
        file.flush()
        os.fdatasync(file.fileno())
        return trouble

    def _write_until(self, flush_at: float, writer: RecordingWriter) -> bool:
        """Empty the queue repeatedly until ``flush_at``; return whether the recording ends."""
        while True:
            ending = self._ending.wait(self._period)
            self._drain(writer)
            if ending or time.monotonic() >= flush_at:
                return ending

    def _drain(self, writer: RecordingWriter) -> None:
        """Write all records queued by now."""
        for _ in range(len(self._queue)):
            t, record = self._queue.popleft()
            if isinstance(record, Gap):
                writer.write_gap(record)
            elif isinstance(record, Note):
                writer.write_note(record)
            elif isinstance(record, Event):
                writer.write_event(record)
            else:
                writer.write_effect(t, record)


def _flush(writer: RecordingWriter, file: BinaryIO) -> None:
    writer.flush()
    file.flush()
    os.fdatasync(file.fileno())
