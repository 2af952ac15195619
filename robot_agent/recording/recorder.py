"""The flight recorder: writes an agent's events and effects to files, on its own thread.

The agent's side only appends to a queue. The thread empties the queue ten times a second and every
0.5 s finishes a chunk and syncs it to the disk, so that a killed process or a power cut costs at
most the last second. Records that cannot be written are counted and marked as a gap.

Without room recording pauses; after an error of the disk it is tried again, in a new file.
"""

from __future__ import annotations

import os
import stat
import threading
import time
from collections import deque
from typing import BinaryIO

from robot_agent.messages.effects import Effect
from robot_agent.messages.events import Event
from robot_agent.recording.recording_retention import RecordingRetention
from robot_agent.recording.recording_writer import Gap, Note, RecordingWriter
from robot_agent.recording.run_files import RunFiles
from robot_agent.recording.run_header import RunHeader

DRAIN_S = 0.1
FLUSH_S = 0.5
RETRY_S = 1.0
"""s after which a failing disk is tried again; doubled each time, up to LONGEST_RETRY_S."""
LONGEST_RETRY_S = 60.0
RESUME_MB = 10.0
"""Room above the bounds from which a paused recording goes on: some minutes of it."""
CLOSE_S = 5.0
"""s to wait for a hanging disk at the end."""
HANG_S = 5.0
"""A disk that has not taken a write for this long hangs, s; slow ones take one or two."""
CAPACITY = 20_000
"""Records that may wait for the disk: about a minute of a robot's traffic."""


class Recorder:
    """Records one run to MCAP files without ever blocking the agent.

    ``failed`` is empty, or one line with the reason why nothing is recorded at present. ``lost``
    counts the records that were dropped. One thread at a time may call the methods.
    """

    def __init__(
        self,
        files: RunFiles,
        header: RunHeader,
        *,
        capacity: int = CAPACITY,
        drain_period: float = DRAIN_S,
        flush_period: float = FLUSH_S,
        retry_after: float = RETRY_S,
        close_wait: float = CLOSE_S,
        room: RecordingRetention | None = None,
    ) -> None:
        """Start the thread that creates the file with its header.

        capacity: records in the queue. drain_period, flush_period, retry_after, close_wait: s.
        room: bounds the use of the disk; None: no bound.
        """
        self.files = files
        self.failed = ""
        self._capacity = capacity
        self._period = drain_period
        self._flush_period = flush_period
        self._retry_after = retry_after
        self._close_wait = close_wait
        self._room = room
        self._queue: deque[tuple[float, Event | Effect | Gap | Note]] = deque()
        self._dropped = 0
        self._unmarked = 0  # dropped since the last gap mark
        self._last_t = 0.0
        self._ending = threading.Event()
        self._alive_at = time.monotonic()
        # Of the recorder's thread:
        self._wait = retry_after
        self._unwritten = 0  # lost by errors of the disk
        self._unflushed = 0  # written since the last flush
        self._gaps_unflushed = 0  # records that gap marks written since then tell of
        self._gap = 0  # of them, those not marked yet
        self._written_t = 0.0
        self._thread = threading.Thread(
            target=self._run, args=(header,), name="recorder", daemon=True
        )
        self._thread.start()

    @property
    def lost(self) -> int:
        """Records that are in no file."""
        return self._dropped + self._unwritten

    @property
    def trouble(self) -> str:
        """``failed``, or one line that the disk hangs: what it takes too late will be lost."""
        if self.failed or time.monotonic() - self._alive_at < HANG_S:
            return self.failed
        return f"{self.files.path}: the disk hangs: what it does not take within a minute is lost"

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
            self.failed = f"{self.files.path}: the disk hangs: the recording's end is lost"

    def _put(self, t: float, record: Event | Effect | Note) -> None:
        self._last_t = t
        if self.failed or len(self._queue) >= self._capacity:
            self._dropped += 1
            self._unmarked += 1
            return
        if self._unmarked:
            self._mark_gap(t)
        self._queue.append((t, record))

    def _mark_gap(self, t: float) -> None:
        self._queue.append((t, Gap(t, self._unmarked)))
        self._unmarked = 0

    def _run(self, header: RunHeader) -> None:
        """Write until ``close``; the thread's own end by an error is set in ``failed``."""
        whole = False
        try:
            self._write_files(header)
            whole = True
        finally:
            if not whole:
                self._fail("its thread has died: start the agent again")
            self._unwritten += sum(not isinstance(record, Gap) for _t, record in self._queue)

    def _write_files(self, header: RunHeader) -> None:
        """Write the run to a file, and after an error of the disk to a new one, until ``close``."""
        ended = False
        while not ended:
            try:
                with self.files.open_next() as file:
                    self._write_file(file, header)
                break
            except (OSError, ValueError) as error:
                self._fail(getattr(error, "strerror", None) or str(error) or repr(error))
            self._gap += self._unflushed + self._gaps_unflushed
            self._unwritten += self._unflushed
            self._unflushed = self._gaps_unflushed = 0
            ended = self._ending.wait(self._wait)
            self._wait = min(2.0 * self._wait, LONGEST_RETRY_S)

    def _fail(self, trouble: str) -> None:
        if self.failed.endswith(trouble):
            return  # each text is an alarm, and the next file tried has another name
        self.failed = f"{self.files.path}: recording stopped: {trouble}"

    def _write_file(self, file: BinaryIO, header: RunHeader) -> None:
        """Write a whole file until ``close``; every flush is synced to the disk."""
        writer = self._begin(file, header)
        ending = False
        while not ending:
            next_flush = time.monotonic() + self._flush_period  # however long the disk takes
            self._flush(writer, file)
            trouble = self._room.free_space() if self._room else ""
            ending = self._pause(trouble) if trouble else self._write_until(next_flush, writer)
        self._drain(writer)
        writer.finish()
        file.flush()
        os.fdatasync(file.fileno())
        self._unflushed = 0

    def _begin(self, file: BinaryIO, header: RunHeader) -> RecordingWriter:
        """Write the header, and a mark of what an earlier file has lost; without it, no file."""
        if self._room:
            self._room.free_space()  # what is too little even so will pause or fail
        try:
            writer = RecordingWriter(file, header)
            if self._gap:
                writer.write_gap(Gap(self._written_t, self._gap))
            self._flush(writer, file)
        except OSError:
            if stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                self.files.path.unlink(missing_ok=True)
            raise
        self._gap = 0
        self._wait = self._retry_after
        self._alive_at = time.monotonic()
        self.failed = ""
        return writer

    def _pause(self, trouble: str) -> bool:
        """Wait for room; return whether the recording ends before that."""
        assert self._room is not None
        self._fail(trouble)
        while not self._ending.wait(self._flush_period):
            self._alive_at = time.monotonic()
            if not self._room.free_space(RESUME_MB):
                self.failed = ""
                return False
        return True

    def _write_until(self, flush_at: float, writer: RecordingWriter) -> bool:
        """Empty the queue repeatedly until ``flush_at``; return whether the recording ends."""
        while True:
            self._alive_at = time.monotonic()
            ending = self._ending.wait(self._period)
            self._drain(writer)
            if ending or time.monotonic() >= flush_at:
                return ending

    def _drain(self, writer: RecordingWriter) -> None:
        """Write all records queued by now."""
        for _ in range(len(self._queue)):
            t, record = self._queue.popleft()
            self._written_t = t
            if isinstance(record, Gap):
                self._gaps_unflushed += record.lost
                writer.write_gap(record)
                continue
            self._unflushed += 1
            if isinstance(record, Note):
                writer.write_note(record)
            elif isinstance(record, Event):
                writer.write_event(record)
            else:
                writer.write_effect(t, record)

    def _flush(self, writer: RecordingWriter, file: BinaryIO) -> None:
        writer.flush()
        file.flush()
        os.fdatasync(file.fileno())
        self._unflushed = self._gaps_unflushed = 0
