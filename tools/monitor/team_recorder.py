"""Writes every payload, undecoded, to an MCAP file under its own key.

Layout: one channel per key ``patrol/<team>/<robot>/<stream>`` with its stream's schema, log times
in wall-clock ns; malformed payloads are kept as well. The attachments ``map/<file>`` hold the
map folder, the metadata record ``team`` the names of map and border.
"""

from __future__ import annotations

import os
import threading
from collections import deque
from collections.abc import Sequence
from pathlib import Path
from typing import BinaryIO

import msgspec
from mcap.well_known import MessageEncoding, SchemaEncoding
from mcap.writer import Writer

from maps.input_limits import MAX_RECORDER_QUEUE_BYTES
from maps.map_folder import MapFolder
from maps.zone import Zone
from maps.zone_file import ZONES_FILE, zones_text
from robot_agent.messages.streams import STREAMS
from robot_agent.recording.recording_writer import CHUNK_BYTES, MAP_ATTACHMENT_PREFIX, OCTET_STREAM
from robot_agent.recording.run_files import OneFile

TEAM_METADATA = "team"
DRAIN_S = 0.1
DRAINS_PER_FLUSH = 7
CAPACITY = 50_000
"""Queue length in payloads: half a minute of fifty robots; in bytes MAX_RECORDER_QUEUE_BYTES."""
MAX_CHANNELS = 2000
"""Most keys recorded; payloads of further ones are counted as lost."""


class TeamRecorder:
    """Records the operator's telemetry; a disk error is reported by ``failed``, never raised.

    ``failed`` is empty, or after a disk error one line with its reason; from then on nothing is
    recorded. ``lost`` counts payloads that were not recorded.
    """

    def __init__(
        self, path: Path, folder: MapFolder | None, border: str, zones: Sequence[Zone] = ()
    ) -> None:
        """Start writing a new file; the others: the monitored site, folder None: no map."""
        self.path = path
        self.failed = ""
        self.lost = 0
        self._folder = folder
        self._border = border
        self._zones = zones
        self._queue: deque[tuple[str, bytes, float]] = deque()
        self._queued_bytes = 0
        self._lock = threading.Lock()
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._run, name="team recorder", daemon=True)
        self._thread.start()

    def on_payload(self, key: str, payload: bytes, wall: float) -> None:
        """Queue a payload received at wall, s since 1970; takes microseconds, from any thread."""
        with self._lock:
            waiting = self._queued_bytes + len(payload)
            if self.failed or len(self._queue) >= CAPACITY or waiting > MAX_RECORDER_QUEUE_BYTES:
                self.lost += 1
                return
            self._queued_bytes = waiting
            self._queue.append((key, payload, wall))

    def close(self) -> None:
        """Write what is queued and finish the file; idempotent."""
        self._ending.set()
        self._thread.join()

    def _run(self) -> None:
        try:
            with OneFile(self.path).open_next() as file:
                self._write(file)
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            self.failed = f"{self.path}: recording stopped: {reason}"
            self._queue.clear()

    def _write(self, file: BinaryIO) -> None:
        """Write until closed; flushes are synced to the disk."""
        writer = Writer(file, chunk_size=CHUNK_BYTES)
        writer.start(profile="", library="border-patrol monitor")
        self._write_head(writer)
        channels: dict[str, int] = {}
        ending = False
        while not ending:
            writer.flush()  # type: ignore[no-untyped-call]
            file.flush()
            _sync(file)
            for _ in range(DRAINS_PER_FLUSH):
                ending = self._ending.wait(DRAIN_S)
                self._drain(writer, channels)
                if ending:
                    break
        writer.finish()  # type: ignore[no-untyped-call]
        file.flush()
        _sync(file)

    def _write_head(self, writer: Writer) -> None:
        name = "" if self._folder is None else self._folder.name
        writer.add_metadata(TEAM_METADATA, {"map": name, "border": self._border})
        if self._folder is not None:
            zones = {ZONES_FILE: zones_text(self._zones).encode()} if self._zones else {}
            for name, data in {**self._folder.files, **zones}.items():
                writer.add_attachment(0, 0, MAP_ATTACHMENT_PREFIX + name, OCTET_STREAM, data)

    def _drain(self, writer: Writer, channels: dict[str, int]) -> None:
        for _ in range(len(self._queue)):
            with self._lock:
                key, payload, wall = self._queue.popleft()
                self._queued_bytes -= len(payload)
            if key not in channels:
                if len(channels) >= MAX_CHANNELS:
                    self.lost += 1
                    continue
                channels[key] = _register(writer, key)
            t = round(wall * 1e9)
            writer.add_message(channels[key], t, payload, t)


def _register(writer: Writer, key: str) -> int:
    """Register a key's channel and return its id; an unknown stream gets no schema."""
    stream = STREAMS.get(key.rpartition("/")[2])
    schema = 0
    if stream is not None:
        definition = msgspec.json.encode(stream.json_schema())
        schema = writer.register_schema(stream.schema_name, SchemaEncoding.JSONSchema, definition)
    return writer.register_channel(key, MessageEncoding.JSON, schema)


def _sync(file: BinaryIO) -> None:
    """Sync written data to the disk; does nothing for pipes and devices."""
    try:
        os.fdatasync(file.fileno())
    except OSError as error:
        if error.errno != 22:  # EINVAL: pipes and the like
            raise
